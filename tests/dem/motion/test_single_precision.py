"""float32 in the time integration: what it costs in accuracy, and where it is refused."""

from __future__ import annotations

import sys
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from dem import (
    ContactLaw,
    Drive,
    History,
    NotRelaxed,
    Scene,
    Settings,
    State,
    packing_key,
    relax,
    step,
)
from tests.conftest import packing
from tests.dem.gases import dense_gas, pressed
from tests.dem.protocols.test_relax import balance

EPS, EPS32 = np.finfo(np.float64).eps, np.finfo(np.float32).eps
PLAN = sys.modules["dem.protocols.plan"]


@pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed: twin kernels")
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("dashpot", [0.0, 0.2])
def test_twin_kernels_agree_to_the_round_off_of_float32(friction, dashpot):
    """200 steps, lists rebuilt: within 100 ε₃₂ of each other and of float64, whose own round-off
    is far below (the control that it is float32 that runs)."""
    law = ContactLaw(friction=friction, dashpot=dashpot)
    states = [dense_gas(3) for _ in range(3)]
    kinds = [("numpy", "float32"), ("numba", "float32"), ("numpy", "float64")]
    for state, (backend, precision) in zip(states, kinds, strict=True):
        step(
            state, law, 0.05, drive=pressed(1e-2), steps=200, skin=0.1, backend=backend,
            precision=precision,
        )  # fmt: skip
    one, two, exact = states
    assert one.reached.forces.pull.dtype == two.reached.forces.pull.dtype == np.complex64
    assert one.reached.forces.twist.dtype == two.reached.forces.twist.dtype == np.float32
    for name in ("positions", "velocities", "spins"):
        a, b, c = (getattr(s, name) for s in (one, two, exact))
        assert np.abs(a - b).max() <= 100 * EPS32, name
        assert np.abs(a - c).max() <= 100 * EPS32, name
    assert np.abs(one.positions - exact.positions).max() > 1e4 * EPS


def noise_of_forces(delta: float, backend: str, far: float = 0.0) -> float:
    """Largest residual, in p, that float32 leaves of a packing at rest after 5 inertial times."""
    p = packing(grains=100, delta=delta)
    history = History(p.pairs, p.images, p.tangential_forces / 0.5)
    state = State(p.positions + far, p.radii, cell=p.cell, history=history)
    steps = int(5 / (0.1 * delta**0.5))
    step(
        state, ContactLaw(), 0.1, drive=pressed(delta), steps=steps, skin=0.2, backend=backend,
        precision="float32",
    )  # fmt: skip
    return float(np.abs(state.reached.forces.pull).max() / delta)


def test_forces_are_as_noisy_as_the_gap_of_a_contact(backend):
    """Residual between 1 and 20 ε₃₂/Δ of p at both ends of what is allowed: no factor L."""
    for delta in (1e-2, 1e-4):
        assert 1 < noise_of_forces(delta, backend) / (EPS32 / delta) < 20


def test_noise_does_not_know_where_in_the_plane_the_grains_are(backend):
    """A thousand diameters from the origin, where float32 coordinates are good to 6e-5 only."""
    assert noise_of_forces(1e-2, backend, far=1000.0) / (EPS32 / 1e-2) < 20


def test_cell_that_shrinks_by_less_than_an_ulp_of_float32_a_step(backend):
    """e dt = 1e-9: after 2000 steps cell and grains have followed, by 2e-6, as in float64."""
    start = State(
        np.array([[3.0, 5.0], [6.0, 5.0]]), np.full(2, 0.5), cell=np.diag([10.0, 10.0]),
        strain_rate=-1e-8,
    )  # fmt: skip
    for precision in ("float64", "float32"):
        state = replace(start)
        step(
            state, ContactLaw(), 0.1, drive=Drive(pressure=1e-16), steps=2000, backend=backend,
            precision=precision,
        )  # fmt: skip
        strain = state.cell[0, 0] / 10 - 1
        assert strain == pytest.approx(-2e-6, rel=1e-3)
        assert state.positions / start.positions - 1 == pytest.approx(
            np.full((2, 2), strain), rel=1e-3
        )


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_relaxed_in_float32_and_polished_it_balances_like_any_other(backend, delta):
    settings = Settings(precision="float32", backend=backend)
    p = relax(Scene(48, delta), 1, settings=settings, progress=False)
    residual, spring = balance(p)
    assert residual <= 1e-9
    assert spring <= 100
    assert p.provenance.settings["precision"] == "float32"


def test_float32_is_refused_for_stiff_grains():
    for settings in (Settings(precision="float32"), Settings(precision="float32", polish=False)):
        with pytest.raises(ValueError, match=r"delta = 1e-05: .* in float32 .* from 0\.0001 on"):
            relax(Scene(48, 1e-5), 1, settings=settings, progress=False)


def test_beyond_the_limit_nothing_comes_to_rest(monkeypatch):
    """Why the limit is there: at Δ = 1e-6 the noise keeps the grains above the speed of rest."""
    monkeypatch.setattr(PLAN, "SMALLEST_IN_SINGLE", 0.0)
    for precision in ("float64", "float32"):
        settings = Settings(precision=precision, longest=60.0, velocity_tolerance=1e-5)
        if precision == "float64":
            relax(Scene(48, 1e-6), 2, settings=settings, progress=False)
            continue
        with pytest.raises(NotRelaxed):
            relax(Scene(48, 1e-6), 2, settings=settings, progress=False)


def test_numbers_of_numpy_do_not_widen_float32(monkeypatch):
    """A pressure or drag of type float64 leaves the grains in float32."""
    kernel, seen = sys.modules["dem.motion.kernels.disks_numpy"], set()
    real = kernel.contact_forces

    def spy(motion, near, *args):
        seen.add((motion.z[near.columns[0]] + near.shift * motion.scale).dtype)
        return real(motion, near, *args)

    monkeypatch.setattr(kernel, "contact_forces", spy)
    drive = Drive(np.float64(0.1), np.float64(1e-2))
    step(
        dense_gas(), ContactLaw(), 0.05, drive=drive, steps=5,
        backend="numpy", precision="float32",
    )  # fmt: skip
    assert seen == {np.dtype(np.complex64)}


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_advice_names_the_other_precision(precision):
    with pytest.raises(NotRelaxed) as caught:
        relax(
            Scene(32, 1e-2), 1, settings=Settings(longest=2.0, precision=precision), progress=False
        )
    assert ("precision = 'float64'" in str(caught.value)) == (precision == "float32")


def test_float32_has_a_key_of_its_own():
    scene = Scene(48, 1e-2)
    double = packing_key(scene, 1, Settings(backend="numpy"))
    assert double == packing_key(scene, 1, Settings(backend="numpy", precision="float64"))
    assert double != packing_key(scene, 1, Settings(backend="numpy", precision="float32"))


def test_unknown_precision():
    with pytest.raises(ValueError, match="precision = 'float16' is not one of float64, float32"):
        Settings(precision="float16")
    state = State(np.array([[0.0, 0.0], [1.0, 0.0]]), np.full(2, 0.5))
    with pytest.raises(ValueError, match="precision = 'half'"):
        step(state, ContactLaw(), 0.1, precision="half")
