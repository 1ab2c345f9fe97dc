"""Studies of other groups' packings: on ours, where answers are known, and on theirs."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from packing.measurement import Measurement
from scaling import ContactNetwork, error_map, mean_force
from studies.experiment import foreign, photoelastic
from studies.registry import STUDIES
from studies.run import Run
from studies.third_party import SETS, third_party
from tests.conftest import packing
from tests.packing.foreign import foreign as foreign_data

pytest.importorskip("clarabel", reason="balance with inequalities needs clarabel")


def set_named(name):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PACKING_DATA", str(foreign_data()))
        try:
            return third_party(name)
        except FileNotFoundError as gone:
            pytest.skip(str(gone))


def test_balance_finds_forces_of_which_nothing_was_missed():
    """Ours, cut open: balance and friction halve the error of equal forces where all is told; a
    friction told too small, or contacts that were missed, cost more than they gain."""
    p = packing(grains=150, delta=1e-3, friction=0.5)
    whole, part = (photoelastic.own_region(p, lost, 0.0) for lost in (0.0, 0.25))
    flat = [seen.error(np.full(seen.network.contacts, seen.mean)) for seen in (whole, part)]
    c = whole.network.contacts
    found = photoelastic.by_balance(whole, 0.5, 1e-3)
    assert whole.error(found[:c]) < 0.9 * flat[0]
    fn, ft = found[:c], found[c:]
    assert fn.min() > -1e-6 * whole.mean
    assert np.all(np.abs(ft) <= 0.5 * fn + 1e-6 * whole.mean)
    short = photoelastic.by_balance(part, 0.5, 1e-3)[: part.network.contacts]
    assert part.error(short) > flat[1]


def test_region_leaves_the_rim_alone():
    p = packing(grains=150, delta=1e-3, friction=0.5)
    seen = photoelastic.own_region(p, 0.0, 0.0)
    x = seen.network.positions[seen.inner]
    assert 0 < len(x) < (seen.network.degrees > 0).sum()
    assert x.min() > photoelastic.RIM * 0.9
    assert x.max() < p.cell[0, 0] - photoelastic.RIM * 0.9


def test_errors_of_ours_are_the_prefactor_times_the_noise():
    """One draw of it lies among a thousand of the error map."""
    p = packing(grains=60, delta=1e-3, friction=0.1)
    found = foreign.errors(p, (0.1, 100.0), ("gppsz", "direct"))
    assert {key[1] for key in found} == {0.1}  # ξ = 100 Δ leaves no disks
    for noise in ("diameter", "position"):
        turned = {"forces": p.forces, "stiffness": 1.0} if noise == "position" else {}
        for method in ("gppsz", "direct"):
            E = error_map(ContactNetwork.from_packing(p), method, noise, **turned)
            draws = E.sample(np.random.default_rng(0), 1000) * 0.1 * p.delta / mean_force(p)
            assert 0.9 * draws.min() < found[noise, 0.1, method] < 1.1 * draws.max()


def test_the_photoelastic_gaps_tell_no_force():
    data = set_named("photoelastic_shear")
    assert isinstance(data, Measurement)
    g = photoelastic.geometry(data)
    assert 16 <= g["xi"] / g["strongest"] < g["xi"] / g["delta"] <= 33
    assert abs(g["correlation"]) < 0.1
    assert g["error"] > 10 * g["spread"]
    assert g["two_sided"] == pytest.approx(0.156, abs=0.002)
    # The control: gaps that are overlaps of these forces tell them, by the same numbers.
    i, j = data.pairs.T
    unit = 2 * data.radii.mean()
    branch = data.positions[j] - data.positions[i]
    r = np.hypot(*branch.T)
    overlap = data.normal_forces / (photoelastic.STIFFNESS * photoelastic.PIXEL)
    pulled = replace(data, radii=np.full(data.grains, unit / 2), pairs=np.array([[0, 1]]),
                     images=None, normal_forces=np.array([0.1]), tangential_forces=None,
                     external=None)  # fmt: skip
    x = np.zeros((data.grains, 2))
    x[1, 0] = unit - 0.1 / (photoelastic.STIFFNESS * photoelastic.PIXEL)
    x[2:, 1] = 10 * unit * np.arange(1, data.grains - 1)
    exact = photoelastic.geometry(replace(pulled, positions=x))
    assert exact["error"] < 1e-9
    assert overlap.shape == r.shape


def test_the_frictional_set_costs_what_ours_cost():
    p = set_named("henkes_dem")
    assert (p.friction, len(p.radii)) == (0.1, 1024)
    found = foreign.errors(p, (0.1,), ("gppsz", "balanced", "direct"))
    ours = foreign.errors(
        packing(150, p.delta, 0.1, seed=2), (0.1,), ("gppsz", "balanced", "direct")
    )
    for key, error in found.items():
        assert error == pytest.approx(ours[key], rel=0.4), key


def test_without_the_data_it_says_so(monkeypatch, capsys, tmp_path):
    monkeypatch.delenv("PACKING_DATA", raising=False)
    for name in ("foreign", "photoelastic"):
        STUDIES[name](Run.of(full=False))
        assert f"{name}: skipped, PACKING_DATA names no folder" in capsys.readouterr().out
    monkeypatch.setenv("PACKING_DATA", str(tmp_path))
    for name in SETS:
        with pytest.raises(FileNotFoundError, match=name):
            third_party(name)
    assert os.environ["PACKING_DATA"] == str(tmp_path)
