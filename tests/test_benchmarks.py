"""The benchmarks on their smallest size: they run, and what they say of physics holds."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from benchmarks import dem_trade, floor, relaxation, rounding, solvers
from benchmarks.tiling import tiled
from dem import refine, relax
from scaling import force_equation, reconstruct, relative_error
from tests.conftest import packing


def test_tiles_are_the_same_packing_many_times():
    """n × n copies: n² times the contacts and faces, the same forces, C and condition O(1)."""
    p = refine(packing(grains=48, delta=1e-3))
    network, forces = tiled(p, 3)
    assert network.contacts == 9 * len(p.pairs)
    assert network.faces == network.contacts - len(network.active)
    assert relative_error(reconstruct(network, p.stiffness).forces, forces) < 1e-11


def test_every_solver_finds_the_forces():
    """To rounding times the condition (squared where GᵀG is formed and not refined), or to 100
    times the tolerance it was given."""
    p = refine(packing(grains=48, delta=1e-3))
    condition = force_equation(tiled(p, 1)[0]).conditioning.condition
    for name in solvers.SOLVERS:
        *_, error = solvers.measure((name, p, 1))
        allowed = 1e-15 * condition**2
        if name.startswith("lsmr"):
            allowed = 100 * float(name.split()[1])
        assert error <= allowed, name


def test_trade_table_has_refusals_and_packings():
    rows = [
        dem_trade.measure((knob, change, 1e-2, 36, 1))
        for knob, change in (
            ("time_step", {"time_step": 0.5}),
            ("unpolished", {"velocity_tolerance": 1e-2, "polish": False}),
        )
    ]
    table = np.array(rows, dem_trade.TABLE)
    assert table["rest"].tolist() == [True, False]
    assert "refused" in dem_trade.text(table)
    assert table["error"][0] < 1e-12


def test_steps_grow_as_the_inverse_root_of_the_deformation(monkeypatch):
    """Exponent 1/2 within 0.2: Δ = 1e-2, 1e-3, 1e-4, three small packings each."""
    monkeypatch.setattr(relaxation, "ways", lambda: {"default": relax})
    with ThreadPoolExecutor(1) as pool:
        table = relaxation.compute(pool, 36, 3, 4)
    for how in dict.fromkeys(table["how"]):
        slope, _ = relaxation.exponent(table, how)
        assert slope == pytest.approx(0.5, abs=0.2)
    assert "steps ~ Δ^-" in relaxation.text(table)


def test_floor_and_rounding_figures_are_drawn():
    table = floor.compute([packing(delta=1e-4), packing(delta=1e-10)])
    assert table["compensated"].max() < 1e-13
    assert table["naive"][1] > 1e5 * table["naive"][0]
    assert floor.plot(table).axes
    assert "1e-10" in floor.text(table)
    assert rounding.plot(rounding.compute([packing(delta=1e-2)], ["float32", "4 decimals"])).axes
