"""What sizes and exact directions leave open is fixed by the mean stress: ranks, not errors only.

Written from the forces alone (balance, closure, Σ r n F), beside the study that measures E.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.linalg import null_space, svdvals

from scaling import ContactNetwork, error_map, force_equation, stress
from studies.estimators import stress as study
from tests.conftest import packing

CASES = [(48, 1e-2, 0.3, 1), (48, 1e-4, 0.3, 2), (60, 1e-3, 0.3, 3), (48, 1e-3, 0.1, 4),
         (60, 1e-4, 1.0, 5)]  # fmt: skip
EPS = np.finfo(float).eps


@cache
def made(case):
    """(packing, network, basis of null M, noise-free closure rows)."""
    grains, delta, friction, seed = case
    p = packing(grains=grains, delta=delta, friction=friction, seed=seed)
    n = ContactNetwork.from_packing(p)
    assert n.coordination < 4
    return p, n, study.self_stress(n), study.noise_free_closure(n)


def same_space(A, B):
    """Largest sine of an angle between the spans of orthonormal rows."""
    assert A.shape == B.shape
    return float(np.max(np.linalg.norm(A - A @ B.T @ B, axis=1)))


@pytest.mark.parametrize("case", CASES)
def test_noise_free_closure_is_unstressed_self_stress(case):
    """{wᵀQ : wᵀQ B = 0} and the f_t of the states of self-stress without mean stress are one space
    of h - 4 dimensions. Round-off ε over the smallest singular value of the condition, the
    antisymmetric stress, O(Δ): allowed is 1e3 ε/(0.01 Δ)."""
    _, n, Z, closure = made(case)
    c, N = n.contacts, len(n.active)
    assert Z.shape[1] == force_equation(n).hyperstaticity == 2 * c - 3 * N + 2
    assert len(closure) == Z.shape[1] - 4
    unstressed = study.unstressed_tangential(n, Z)
    assert same_space(unstressed, closure) < 1e3 * EPS / (0.01 * case[1])


@pytest.mark.parametrize("case", CASES)
def test_a_noise_free_row_as_forces(case):
    """Turned by 90° the jumps of a row's potential balance every grain, and cross no cell."""
    _, n, _, _ = made(case)
    equation = force_equation(n)
    Q, incidence = equation.Q.toarray(), n.loops.incidence.toarray()
    spread = np.zeros((n.contacts, n.grains))
    for k in (0, 1):
        np.add.at(spread, (np.arange(n.contacts), n.pairs[:, k]), 1.0)
    w = null_space((Q @ spread).T, rcond=1e-10)
    jumps = incidence.T @ w.reshape(2, len(n.loops), -1).transpose(1, 0, 2).reshape(
        len(n.loops), -1
    )
    jumps = jumps.reshape(n.contacts, 2, -1)
    along, across = (np.einsum("ek,ekm->em", d, jumps) for d in (n.normals, n.tangents))
    np.testing.assert_allclose(along, (w.T @ Q).T, atol=64 * EPS * len(n.loops))
    for f in np.vstack([across, along]).T:
        assert abs(equation.M @ f).max() < 1e4 * EPS
        assert abs(stress(n, f)).max() < 1e4 * EPS


@pytest.mark.parametrize("case", CASES)
def test_the_four_components_of_the_stress_close_the_four_modes(case):
    """Each closes one; rows of branches without their lattice vectors, the total force and
    balance rows repeated close none."""
    _, n, Z, closure = made(case)
    rows = study.stress_rows(n)
    assert [study.open_modes(closure, rows[:k], Z) for k in range(5)] == [4, 3, 2, 1, 0]
    assert study.open_modes(closure, study.uncrossed_rows(n), Z) == 4
    M = force_equation(n).M.toarray()
    assert study.open_modes(closure, M, Z) == 4
    assert study.open_modes(closure, np.vstack([rows[0]] * 4), Z) == 3


@pytest.mark.parametrize("case", CASES)
def test_a_stressed_state_gives_no_noise_free_row(case):
    """Negative control of the identity: f_t of a state of self-stress drawn from all of null M,
    mean stress and all, is not among the closure rows without noise."""
    _, n, Z, closure = made(case)
    a = np.random.default_rng(0).standard_normal((Z.shape[1], 4))
    f_t = (Z @ a)[n.contacts :].T
    f_t /= np.linalg.norm(f_t, axis=1)[:, None]
    assert np.linalg.norm(f_t - f_t @ closure.T @ closure, axis=1).min() > 1e-3


def test_above_four_contacts_more_stays_open():
    """Z = 4.8: closure then has redundant rows, and the stress is not all that is missing."""
    n = ContactNetwork.from_packing(packing(grains=48, delta=1e-1, seed=1))
    assert n.coordination > 4.5
    Z, closure = study.self_stress(n), study.noise_free_closure(n)
    assert study.open_modes(closure, study.stress_rows(n), Z) > 4


def test_the_antisymmetric_component_is_of_the_order_of_the_deformation():
    """Its row on null M, and the fourth singular value of the error map, fall with Δ; the three
    symmetric ones stay O(1)."""
    lengths, singular = [], []
    for case in CASES[:2]:
        _, n, Z, _ = made(case)
        σ = svdvals(study.stress_rows(n) @ Z)
        assert σ[2] > 0.1
        lengths.append(σ[3])
        s = svdvals(study.optimal_map(n, study.stress_rows(n)[:0]))
        assert s[2] > 0.1
        assert s[4] < 1e-9
        singular.append(s[3])
    for large, small in (lengths, singular):
        assert 10 < large / small < 1000  # Δ falls by 100


def test_error_with_the_stress_given():
    """Without rows the map is that of `optimal`; each component of the stress lowers E, the three
    together to O(Δ) of what it was; rows that say nothing of the forces leave it as it is."""
    _, n, _, _ = made(CASES[1])
    rows = study.stress_rows(n)
    K = [np.linalg.norm(study.optimal_map(n, rows[:k])) for k in range(4)]
    plain = error_map(n, "optimal", data="sizes").matrix
    assert K[0] == pytest.approx(np.linalg.norm(plain), rel=1e-6)
    assert K[0] > K[1] > K[2] > 100 * K[3]
    wrong = study.optimal_map(n, study.uncrossed_rows(n)[:3])
    assert np.linalg.norm(wrong) == pytest.approx(K[0], rel=1e-6)
