"""A contact law of somebody else's, in one file: springs that stiffen, f = κ δ (1 + δ/δ₀)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from dem import ContactLaw, Packing, Scene, Settings, packing_key, ramp, refine, relax, step
from dem.balance.tangent import Equilibrium
from dem.model.law import stable_time_step
from packing.contact_law import Linear, PerContact
from packing.provenance import Provenance
from tests.conftest import packing
from tests.dem.gases import dense_gas, pressed
from tests.dem.protocols.test_relax import balance

EPS = np.finfo(float).eps


@dataclass(frozen=True)
class Stiffening:
    """f = κ δ (1 + δ/δ₀) with κ = 1; k_t as soft as a share of it that grows with the overlap."""

    onset: float = 1e-2
    grip: float = 0.0

    def force(self, overlap):
        return overlap * (1 + overlap / self.onset)

    def overlap(self, force):
        return 0.5 * self.onset * (np.sqrt(1 + 4 * force / self.onset) - 1)

    def slope(self, overlap):
        return 1 + 2 * overlap / self.onset

    def tangential_stiffness(self, overlap):
        return 0.5 * (1 + self.grip * overlap / self.onset)

    def delta(self, pressure):
        return float(self.overlap(pressure))


@dataclass(frozen=True)
class Hertz:
    """f = δ^(3/2), k_t = 2/3 df/dδ: no spring at all before contact."""

    def force(self, overlap):
        return np.abs(overlap) ** 1.5 * np.sign(overlap)

    def overlap(self, force):
        return np.abs(force) ** (2 / 3) * np.sign(force)

    def slope(self, overlap):
        return 1.5 * np.sqrt(np.abs(overlap))

    def tangential_stiffness(self, overlap):
        return np.sqrt(np.abs(overlap))

    def delta(self, pressure):
        return float(self.overlap(pressure))


NUMPY = Settings(backend="numpy")


@pytest.mark.parametrize("law", [Stiffening(), Stiffening(grip=1.0), Hertz()], ids=repr)
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("delta", [1e-2, 1e-3])
def test_a_packing_of_another_law_rests(law, friction, delta):
    """Balanced as any other, and f_n = f(δ) to the rounding of positions, κ ε L; read as linear
    springs (the control) it is far off."""
    p = relax(Scene(48, delta, friction=friction, contact=law), 1, settings=NUMPY, progress=False)
    assert balance(p)[0] <= 1e-9
    stiffest = law.slope(p.overlaps).max()
    rounding = stiffest * EPS * p.cell.max()
    assert np.abs(p.normal_forces - law.force(p.overlaps)).max() <= 10 * rounding
    assert np.abs(p.normal_forces - p.stiffness * p.overlaps).max() > 1e-3 * p.pressure
    assert p.pressure == law.force(np.array([delta]))[0]
    assert p.delta == pytest.approx(delta, rel=4 * EPS)
    assert np.all(np.abs(p.tangential_forces) <= friction * p.normal_forces + 1e-9 * p.pressure)


def test_the_law_is_on_record(tmp_path):
    law = Stiffening(grip=0.5)
    p = relax(Scene(24, 1e-2, contact=law), 1, settings=NUMPY, progress=False)
    p.save(tmp_path / "p.npz")
    p = Packing.load(tmp_path / "p.npz")
    told = {"law": f"{__name__}.Stiffening", "onset": 1e-2, "grip": 0.5}
    assert p.provenance.scene["contact"] == told
    assert p.stiffness_ratio is None
    for resumed in (refine, lambda p: ramp(p, [2e-2], progress=False)):
        with pytest.raises(ValueError, match=r"made with contact = .*Stiffening.* linear springs"):
            resumed(p)


def test_laws_have_keys_of_their_own():
    scenes = [Scene(24, 1e-2, contact=c) for c in ("linear", Stiffening(), Stiffening(2e-2))]
    assert len({packing_key(scene, 1, NUMPY) for scene in scenes}) == 3
    assert len({hash(scene) for scene in scenes}) == 3


def test_linear_springs_are_what_they_are_called():
    assert Scene(24, 1e-2, contact=Linear(1.0, 0.25)) == Scene(24, 1e-2, stiffness_ratio=0.25)
    assert ContactLaw(contact=Linear(2.0, 0.25)) == ContactLaw(2.0, 0.25)
    law = replace(ContactLaw(2.0), friction=0.1)
    assert (law.stiffness, law.tangential, law.friction) == (2.0, 1.0, 0.1)


class LinearBySomebody:
    """Linear springs that nobody recognises."""

    def __init__(self) -> None:
        law = Linear()
        self.force, self.overlap, self.slope = law.force, law.overlap, law.slope
        self.tangential_stiffness, self.delta = law.tangential_stiffness, law.delta


def test_the_general_path_moves_linear_springs_bit_for_bit():
    """What the fast path leaves out changes no digit, dashpot included."""
    one, two = dense_gas(3), dense_gas(3)
    for state, law in ((one, ContactLaw(dashpot=0.1)), (two, by_somebody(dashpot=0.1))):
        step(state, law, 0.05, drive=pressed(1e-2), steps=200, skin=0.2, backend="numpy")
    for name in ("positions", "velocities", "spins", "cell"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name


def by_somebody(**constants: float) -> ContactLaw:
    return ContactLaw(contact=LinearBySomebody(), **constants)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_tangent_of_another_law_is_the_derivative_of_the_residual(friction):
    """As for linear springs, where k_t does not change with the overlap."""
    state, law = dense_gas(5), ContactLaw(contact=Stiffening(), friction=friction)
    step(state, law, 0.05, drive=pressed(1e-2), steps=50, skin=0.2, backend="numpy")
    balance = Equilibrium(state, state.reached.near, replace(law, friction=0.7 * friction), 1e-2)
    rng, h = np.random.default_rng(0), 1e-7
    trial = balance.trial(np.zeros(3 * len(state.radii) + 1))
    for _ in range(5):
        move = rng.uniform(-1, 1, len(trial.y))
        if not friction:
            move[2 * len(state.radii) : -1] = 0
        ends = [balance.trial(sign * h * move) for sign in (1, -1)]
        up, down = (t.residual(t.normal, t.tangential) for t in ends)
        slope = (up - down) / (2 * h)
        assert np.abs(slope - balance.tangent(trial) @ move).max() < 1e-5


def test_the_time_step_knows_the_stiffest_contact():
    """Up to the overlap foreseen: f' = 1 + 2 δ/δ₀ = 21 at δ = 10 δ₀; of linear springs at any."""
    law = ContactLaw(contact=Stiffening())
    ratio = stable_time_step(law, 1.0, 0.1, 1e-1) / stable_time_step(law, 1.0, 0.1, 1e-9)
    assert ratio == pytest.approx(21**-0.5, rel=1e-6)
    assert stable_time_step(ContactLaw(), 1.0, 0.1, 1e-1) == stable_time_step(
        ContactLaw(), 1.0, 0.1
    )


def test_what_knows_linear_springs_only_says_so():
    law, scene = ContactLaw(contact=Stiffening()), Scene(24, 1e-2, contact=Stiffening())
    single = Settings(backend="numpy", precision="float32")
    with pytest.raises(ValueError, match=r"Stiffening\(.*precision = 'float32' knows linear"):
        relax(scene, 1, settings=single)
    with pytest.raises(ValueError, match=r"Stiffening\(.*precision = 'float32' knows linear"):
        step(dense_gas(), law, 0.1, backend="numpy", precision="float32")
    with pytest.raises(ValueError, match=r"Stiffening\(.*continued, and that knows linear"):
        relax(replace(scene, delta=1e-7), 1, settings=NUMPY)
    for name in ("stiffness", "stiffness_ratio"):
        with pytest.raises(ValueError, match=rf"Stiffening\(.* has no {name}: it is not linear"):
            getattr(law, name)


def test_the_compiled_kernel_refuses_other_laws_before_any_work():
    pytest.importorskip("numba")
    for backend in ("numba", "auto"):
        refusal = r'Stiffening\(.*knows linear springs and Hertz only; take backend="numpy"'
        with pytest.raises(ValueError, match=refusal):
            relax(Scene(10**6, 1e-2, contact=Stiffening()), 1, settings=Settings(backend=backend))
        with pytest.raises(ValueError, match=refusal):
            step(dense_gas(), ContactLaw(contact=Stiffening()), 0.1, backend=backend)


@dataclass(frozen=True)
class Attracting(Stiffening):
    def force(self, overlap):
        return -overlap


@dataclass(frozen=True)
class Holding(Stiffening):
    things: object = 1j


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        (PerContact(np.ones(3)), "a law per contact, but contacts come and go"),
        (LinearBySomebody(), "a law of a scene is a frozen dataclass"),
        (Attracting(), r"has a force of -0\.01 at Δ"),
        (Holding(), r"things of contact = 1j is a complex"),
        (Holding(things=[1.0]), r"can be hashed \(unhashable type: 'list'\)"),
        (Linear(2.0), r"contact = Linear\(stiffness=2\.0.* in units of κ = 1"),
        (Stiffening, "contact = .* is not built yet; use 'linear'"),
        (3, "contact = 3 is not built yet; use 'linear'"),
    ],
    ids=range(8),
)
def test_odd_contacts_are_refused(contact, message):
    with pytest.raises(ValueError, match=message):
        Scene(24, 1e-2, contact=contact)


def test_two_kinds_of_springs_are_one_too_many():
    with pytest.raises(ValueError, match=r"stiffness_ratio = 0\.7 and contact = Stiffening"):
        Scene(24, 1e-2, contact=Stiffening(), stiffness_ratio=0.7)
    with pytest.raises(ValueError, match=r"Linear\(stiffness=2\.0.*Stiffening.*one of the two"):
        ContactLaw(2.0, contact=Stiffening())
    with pytest.raises(ValueError, match="contact = 3 is no contact law"):
        ContactLaw(contact=3)


def test_a_packing_of_linear_springs_has_none_on_record():
    assert packing().provenance.scene["contact"] == "linear"
    assert packing().stiffness_ratio == 0.5
    assert Provenance().scene is None
