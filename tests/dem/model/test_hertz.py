"""Elastic spheres in motion and at rest: closed loops make no energy, packings balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dem import ContactLaw, Packing, Scene, Settings, State, ramp, refine, relax, step
from dem.balance.tangent import Equilibrium
from dem.motion.backends import kernel_of
from dem.motion.neighbours import find_neighbours
from dem.motion.views import motion_of
from packing.contact_law import Hertz, Linear, law_between
from scaling import ContactNetwork, amplification_of, collapse, reconstruct, relative_error
from tests.dem.gases import dense_gas, pressed
from tests.dem.protocols.test_relax import balance

EPS = np.finfo(float).eps
LOOSE, TIGHT, SHEAR = 0.01, 0.04, 0.002
LOOPS = {
    "load, shear tight, unload, unshear loose": [(TIGHT, 0), (TIGHT, 1), (LOOSE, 1), (LOOSE, 0)],
    "shear loose, load, unshear tight, unload": [(LOOSE, 1), (TIGHT, 1), (TIGHT, 0), (LOOSE, 0)],
}
"""Overlap and shear at the corners, from (LOOSE, 0) on."""


def work(loop: list[tuple[float, float]], backend: str = "numpy", steps: int = 2000) -> float:
    """What is done on two grains that are taken around, the second held, on straight ways."""
    if backend == "numba":
        pytest.importorskip("numba")
    law, kernel = ContactLaw(contact=Hertz(), friction=1e3), kernel_of(backend)
    state = State([[0.0, 0.0], [1 - LOOSE, 0.0]], [0.5, 0.5])
    near = find_neighbours(state, 0.3)
    m, near = motion_of(state, near, False, False)
    done, at = 0.0, (LOOSE, 0.0)
    force = kernel.contact_forces(m, near, law, 0.0).pull[1]
    for corner in loop:
        end = 1 - corner[0] + 1j * SHEAR * corner[1]
        begin = 1 - at[0] + 1j * SHEAR * at[1]
        way = (end - begin) / steps
        m.v[1] = way  # the time step is 1
        for k in range(steps):
            m.z[1] = begin + (k + 1) * way
            after = kernel.contact_forces(m, near, law, 1.0).pull[1]
            done -= ((force + after) / 2 * np.conj(way)).real
            force = after
        at = corner
    return done


@pytest.mark.parametrize("backend", ["numpy", "numba"])
@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_closed_loops_make_no_energy(loop, backend):
    """They cost half of (k_t tight - k_t loose) shear², to O(δ): the branch turns."""
    k = Hertz().tangential_stiffness(np.array([LOOSE, TIGHT]))
    assert work(loop, backend) == pytest.approx(0.5 * (k[1] - k[0]) * SHEAR**2, rel=0.05)


@pytest.mark.parametrize(
    ("kept", "makes"),
    [
        # f_t kept as it is: tight in, loose out
        (lambda k, before, now: k(before) / np.maximum(k(now), 1e-300), 0),
        # the slip kept as it is, f_t = k_t u: loose in, tight out
        (lambda k, before, now: np.ones_like(now), 1),
    ],
    ids=["without rescaling", "history of slip"],
)
def test_without_rescaling_a_loop_makes_energy(monkeypatch, kept, makes):
    """The controls: each of the two other ways makes energy in one of the two loops."""
    k_t = Hertz().tangential_stiffness
    monkeypatch.setattr(ContactLaw, "kept", lambda self, before, now: kept(k_t, before, now))
    energies = [work(loop) for loop in LOOPS.values()]
    assert energies[makes] < -0.3 * abs(energies[1 - makes])


@pytest.mark.parametrize(("friction", "dashpot"), [(0.0, 0.0), (0.3, 0.0), (0.3, 0.2)])
def test_twin_kernels_agree(friction, dashpot):
    pytest.importorskip("numba")
    law = ContactLaw(contact=Hertz(), friction=friction, dashpot=dashpot)
    one, two = dense_gas(2), dense_gas(2)
    for state, backend in ((one, "numpy"), (two, "numba")):
        step(state, law, 0.05, drive=pressed(1e-2), steps=300, skin=0.2, backend=backend)
    for name in ("positions", "velocities", "spins", "cell"):
        a, b = getattr(one, name), getattr(two, name)
        assert np.abs(a - b).max() < 1e-9 * max(1.0, np.abs(a).max()), name


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_tangent_is_the_derivative_of_the_residual(friction):
    """On the branch, loading or unloading, that a small move takes each contact to."""
    state, law = dense_gas(5), ContactLaw(contact=Hertz(), friction=friction)
    step(state, law, 0.05, drive=pressed(1e-2), steps=50, skin=0.2, backend="numpy")
    balance_ = Equilibrium(state, state.reached.near, replace(law, friction=0.7 * friction), 1e-2)
    rng, h = np.random.default_rng(0), 1e-6
    for _ in range(5):
        far = 1e-3 * rng.uniform(-1, 1, 3 * len(state.radii) + 1)
        move = rng.uniform(-1, 1, len(far))
        if not friction:
            far[2 * len(state.radii) : -1] = move[2 * len(state.radii) : -1] = 0
        trial = balance_.trial(far)
        ends = [balance_.trial(far + sign * h * move) for sign in (1, -1)]
        up, down = (t.residual(t.normal, t.tangential) for t in ends)
        slope, tangent = (up - down) / (2 * h), balance_.tangent(trial) @ move
        kinks = [t.sliding != trial.sliding for t in ends] + [
            t.bearing != trial.bearing for t in ends
        ]
        assert not np.any(kinks)
        assert np.abs(slope - tangent).max() < 1e-4


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_packings_rest(delta, friction):
    """Balanced, with f_n = f(δ) to the rounding of positions, and the forces come back from
    sizes and directions; read as linear springs (the control) they do not."""
    settings = Settings(backend="numpy" if delta > 1e-5 else "auto")
    p = relax(Scene(48, delta, friction=friction, contact="hertz"), 1, settings=settings,
              progress=False)  # fmt: skip
    assert balance(p)[0] <= 1e-12
    rounding = p.law.slope(p.overlaps).max() * EPS * p.cell.max()
    assert np.abs(p.normal_forces - p.law.force(p.overlaps)).max() <= 10 * rounding
    assert p.pressure == pytest.approx(delta**1.5, rel=1e-12)
    assert p.delta == pytest.approx(delta, rel=1e-12)
    n, smooth = ContactNetwork.from_packing(p), friction == 0
    for method in ("gppsz", "direct"):
        found = reconstruct(n, p.law, method, frictional=not smooth)
        assert relative_error(found, p) < 1e-9 / delta * 1e-2
    wrong = reconstruct(n, p.stiffness, frictional=not smooth)
    assert relative_error(wrong, p) > 0.02


def test_the_law_is_on_record(tmp_path):
    p = relax(Scene(24, 1e-2, contact=Hertz(poisson=0.2)), 1, progress=False)
    p.save(tmp_path / "p.npz")
    loaded = Packing.load(tmp_path / "p.npz")
    assert loaded.law.poisson == 0.2
    assert np.array_equal(loaded.law.force(p.overlaps), p.law.force(p.overlaps))
    assert loaded.stiffness_ratio is None
    for resumed in (refine, lambda p: ramp(p, [2e-2], progress=False)):
        with pytest.raises(ValueError, match=r"made with contact = .*Hertz.* linear springs"):
            resumed(p)
    assert isinstance(relax(Scene(24, 1e-2), 1, progress=False).law, Linear)
    strange = p.noted(scene=p.provenance.scene | {"contact": {"law": "some.where.Law"}})
    with pytest.raises(ValueError, match=r"'some.where.Law', which is not known here"):
        _ = strange.law


def test_the_prefactor_is_that_of_the_law():
    """E = C ξ/Δ with Δ = (p/κ)^(2/3), measured at ξ = 1e-6 Δ where closure is linear; the same
    draws: exactly. Taken for linear springs (the control) E is the bias, whatever ξ."""
    p = relax(Scene(48, 1e-3, contact="hertz"), 1, progress=False)
    rows = collapse([p], [1e-6, 2e-6], np.random.default_rng(0), draws=40)
    for ratio in (1e-6, 2e-6):
        errors = rows["error"][rows["ratio"] == ratio]
        measured = np.sqrt(np.mean(errors**2)) / ratio
        # 40 draws of some hundred sources: the mean square is good to 5 %
        assert measured == pytest.approx(float(amplification_of(p)), rel=0.15)
    assert rows["C"][0] == float(amplification_of(p))

    class Misread:
        def __init__(self) -> None:
            for name in ("positions", "radii", "pairs", "cell", "images", "external", "forces",
                         "pressure", "stiffness", "delta", "friction"):  # fmt: skip
                setattr(self, name, getattr(p, name))

    wrong = collapse([Misread()], [1e-6], np.random.default_rng(0), draws=2)
    assert wrong["error"].min() > 1e4 * rows["error"].max()


def test_a_part_of_a_packing_has_the_law_of_its_contacts():
    """The law of all contacts is refused for a part; made for the part, its forces come out."""
    p = relax(Scene(100, 1e-3, contact="hertz"), 1, progress=False)
    n = ContactNetwork.from_packing(p)
    middle = np.linalg.norm(p.positions - np.diag(p.cell) / 2, axis=1) < 3
    part = n.inside(middle, p.normal_forces, p.tangential_forces)
    with pytest.raises(ValueError, match=rf"is not one of {part.contacts} contacts"):
        reconstruct(part, p.law)
    found = reconstruct(part, law_between(Hertz(), part.radii, part.pairs))
    true = p.normal_forces[part.contact_index]
    assert relative_error(found.normal, true, frictional=False) < 1e-8
