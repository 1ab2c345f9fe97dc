"""The barrier method of `bounded` finds the minimum that clarabel finds, and proves it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import diags_array

from scaling import perturb, reconstruct
from scaling.equation.force_equation import force_equation
from scaling.estimators.bounded import conditions, maximum
from scaling.estimators.bounded.barrier import interior_point
from scaling.estimators.bounded.barrier.condensed import Blocks, Condensed
from scaling.estimators.bounded.bounded import Bounded
from scaling.estimators.bounded.order import sites_of
from scaling.estimators.bounded.program import program_of
from tests.conftest import packing
from tests.scaling.packings import network_of

pytest.importorskip("clarabel")
NEVER = 10**9


def equation_of(delta: float = 1e-3, xi: float = 1e-4, noise: str = "position"):
    p = packing(grains=100, delta=delta)
    noisy = perturb(network_of(p), xi, np.random.default_rng(2), noise)
    return p, noisy, force_equation(noisy).with_law(p.stiffness)


def task_of(friction: float = 0.3, xi: float = 1e-4):
    p, _, equation = equation_of(xi=xi)
    made = Bounded(friction=friction, pressure=p.pressure, xi=xi, noise="position")
    f = np.zeros(equation.unknowns)
    posterior = made.posterior(equation)
    f[: equation.network.contacts] = posterior.mean_force
    return program_of(posterior, f)


def cost(task, z) -> float:
    return float(z @ (task.P * z) / 2 + task.q @ z)


@pytest.fixture
def everywhere(monkeypatch):
    monkeypatch.setattr(interior_point, "FROM", 0)


@pytest.mark.parametrize("noise", ["position", "diameter"])
@pytest.mark.parametrize("xi", [1e-4, 1e-3])
def test_forces_are_those_of_clarabel(monkeypatch, noise, xi):
    """To clarabel's tolerance of the cost, 1e-8, which leaves 1e-5 in forces where it is flat."""
    p, noisy, _ = equation_of(xi=xi, noise=noise)
    known = {"xi": xi, "noise": noise, "friction": 0.3, "pressure": p.pressure}
    found = {}
    for start in (0, NEVER):
        monkeypatch.setattr(interior_point, "FROM", start)
        found[start] = reconstruct(noisy, p.stiffness, "bounded", **known)
    barrier, clarabel = found[0], found[NEVER]
    assert (barrier.solver, clarabel.solver) == ("barrier", "clarabel")
    assert abs(barrier.forces - clarabel.forces).max() < 3e-5 * abs(clarabel.forces).max()
    assert barrier.misfit == pytest.approx(clarabel.misfit, rel=5e-3)
    assert barrier.error_estimate < 1e-8
    assert (barrier.normal >= -1e-9 * barrier.normal.mean()).all()


def test_no_cost_is_less_and_all_conditions_hold(everywhere, monkeypatch):
    task = task_of()
    found = interior_point.by_interior_point(task)
    z, _ = maximum.minimise(task.P, task.q, task.equal, task.b, task.cone)
    assert cost(task, found.z) <= cost(task, z) + 1e-7 * abs(cost(task, z))
    assert abs(task.equal @ found.z - task.b).max() < 1e-10
    assert (task.cone @ found.z).max() < 1e-10
    assert found.tolerance < 1e-9
    # The limits matter: without them the forces would be others.
    assert ((task.cone @ found.z) > -1e-6).sum() > 5


def test_a_point_that_is_not_the_minimum_is_refused(everywhere):
    """Negative control of the proof: forces off by 1e-5, or multipliers by a thousandth."""
    task = task_of()
    blocks, _ = interior_point.prepared_for(task)
    found = interior_point.by_interior_point(task, gap=interior_point.ROUGH)
    assert found.tolerance > interior_point.FINE  # a rough one proves nothing
    good = interior_point.by_interior_point(task)
    at, ν = good.inside.at, good.inside.ν
    off = replace(good.inside, at=replace(at, φ_t=at.φ_t + 1e-5))
    assert interior_point.violation(blocks, off, 0.3) > 1e-6
    assert interior_point.violation(blocks, replace(good.inside, ν=1.001 * ν), 0.3) > 1e-6


def test_what_is_not_proven_goes_to_the_other_solver(everywhere, monkeypatch):
    p, noisy, _ = equation_of()
    known = {"xi": 1e-4, "noise": "position", "friction": 0.3, "pressure": p.pressure}
    monkeypatch.setattr(interior_point, "_SOLVED", 0.0)
    assert reconstruct(noisy, p.stiffness, "bounded", **known).solver == "clarabel"


def test_what_is_infeasible_is_refused_as_before(everywhere):
    p, noisy, _ = equation_of()
    with pytest.raises(ValueError, match="no forces satisfy"):
        reconstruct(
            noisy, p.stiffness, "bounded", xi=1e-9, noise="diameter", friction=0.1,
            pressure=p.pressure,
        )  # fmt: skip


def test_forms_that_it_does_not_know_are_left_to_the_other(everywhere):
    assert interior_point.prepared_for(task_of(friction=0.05)) is None
    assert interior_point.prepared_for(task_of(friction=1e9)) is None
    assert interior_point.prepared_for(task_of()) is not None


def test_the_condensed_system_is_the_whole_one(everywhere):
    """For weights w and multipliers ν the least of the cost with ν r + w r²/2."""
    task = task_of()
    blocks, c, rng = Blocks(task), task.unknowns // 2, np.random.default_rng(0)
    w, ν = rng.uniform(0, 10, (2, c)), rng.uniform(0, 1, (2, c))
    at = Condensed(blocks, sites_of(task.posterior), w, 0.3).point(ν)
    E, cone = task.equal.toarray(), task.cone.toarray()
    P = np.diag(task.P) + cone.T @ (w.ravel()[:, None] * cone)
    K = np.block([[P, E.T], [E, np.zeros((len(E), len(E)))]])
    right = np.concatenate([-task.q - cone.T @ ν.ravel(), task.b])
    z = np.linalg.lstsq(K, right, rcond=1e-13)[0][: len(task.P)]
    assert abs(at.z - z).max() < 1e-8 * abs(z).max()
    beyond = (diags_array(np.ones(2 * c)) @ task.cone @ z).reshape(2, c)
    assert abs(at.beyond(0.3) - beyond).max() < 1e-8


def test_the_misfit_is_that_of_the_whole_system(monkeypatch):
    task = task_of()
    z, _ = maximum.minimise(task.P, task.q, task.equal, task.b, task.cone)
    found = []
    for start in (0, NEVER):
        monkeypatch.setattr(interior_point, "FROM", start)
        found.append(conditions.misfit_of_bounded(task, z))
    one, other = found
    assert one.most == pytest.approx(other.most, rel=1e-6)
    assert one.value == pytest.approx(other.value, rel=1e-6)
