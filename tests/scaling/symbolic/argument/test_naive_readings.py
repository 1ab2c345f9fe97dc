"""Loop sums that Qᵀ annihilates exist, and no sizes make them.

Rounding: null vectors come from a singular value decomposition, so products with Q are zero to
eps times the largest singular value of Q and the size of the matrix.
"""

from __future__ import annotations

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation
from scaling.symbolic import bowtie, null_space, rhombus, ring, triangle, wheel
from scaling.symbolic.loops.number_field import ExactField
from tests.conftest import packing

EPS = np.finfo(float).eps


class Closure:
    """Q of a packing's network, the sums it cannot make, and rounding."""

    def __init__(self, grains, delta, friction, seed):
        p = packing(grains, delta, friction=friction, seed=seed)
        self.network = ContactNetwork.from_packing(p)
        self.equation = force_equation(self.network, frictional=friction > 0)
        self.Q = self.equation.Q.toarray()
        left, singular, _ = np.linalg.svd(self.Q)
        self.rounding = 10 * EPS * singular[0] * max(self.Q.shape)
        self.singular = singular[singular > self.rounding]
        self.unmade = left[:, len(self.singular) :]
        self.active = int((self.network.degrees > 0).sum())


# Z = 4.67 (N = 48 and 150), 5.5 and 4.09
DENSE = [(48, 1e-1, 0.3, 1), (48, 1e-1, 0.3, 2), (150, 1e-1, 0.3, 1), (60, 1e-1, 0.0, 1),
         (48, 1e-3, 0.0, 1)]  # fmt: skip


@pytest.mark.parametrize("scene", DENSE, ids=str)
def test_dense_packings_have_sums_that_transposed_closure_annihilates(scene):
    """Qᵀs = 0 for c - 2N + 1 independent s ≠ 0: "for s = 0 only" is false."""
    found = Closure(*scene)
    count = found.network.contacts - 2 * found.active + 1
    assert count > 2
    assert found.unmade.shape[1] == count
    assert np.abs(found.Q.T @ found.unmade).max() < found.rounding


def test_fifty_one_of_them_at_z_of_4_67():
    found = Closure(150, 1e-1, 0.3, 1)
    assert round(2 * found.network.contacts / found.active, 2) == 4.67
    assert found.unmade.shape[1] == 51


def test_even_a_sparse_packing_has_two():
    """The same s on all faces: every contact lies between two of them, once in each direction."""
    found = Closure(40, 1e-3, 0.3, 1)
    assert 2 * found.network.contacts < 4 * found.active
    assert found.unmade.shape[1] == 2
    faces = found.Q.shape[0] // 2
    for vector in found.unmade.T:
        for component in (vector[:faces], vector[faces:]):
            assert np.ptp(component) < found.rounding


@pytest.mark.parametrize("scene", DENSE, ids=str)
def test_no_sizes_make_them(scene):
    """QᵀQσ = 0 only if Qσ = 0: on the range of Q the map Qᵀ is as regular as Q itself.

    |QᵀQσ| >= s_min |Qσ| with s_min the smallest singular value that is not zero; sizes of all
    kinds, the true ones included, keep to it, and a sum with a part that none can make does not.
    """
    found = Closure(*scene)
    rng = np.random.default_rng(0)
    c = found.network.contacts
    for sizes in (found.network.sigma, *rng.standard_normal((20, c)), *np.eye(c)):
        s = found.Q @ sizes
        assert np.linalg.norm(s @ found.unmade) < found.rounding * np.linalg.norm(sizes)
        least = found.singular[-1] * np.linalg.norm(s) - found.rounding * np.linalg.norm(sizes)
        assert np.linalg.norm(found.Q.T @ s) > least
    stray = found.unmade[:, 0]  # negative control
    assert np.linalg.norm(found.Q.T @ stray) < found.singular[-1] / 1000


@pytest.mark.parametrize("scene", DENSE, ids=str)
def test_turned_by_90_degrees_they_are_potentials_of_unloaded_normal_forces(scene):
    """f_e = t·(s_left - s_right) balances on every grain without loads."""
    found = Closure(*scene)
    network = found.network
    incidence = network.loops.incidence.toarray()
    faces = len(incidence)
    rows = 2 * found.active
    M_n = found.equation.M.toarray()[:rows, : network.contacts]
    for vector in found.unmade.T:
        jump = incidence.T @ np.column_stack([vector[:faces], vector[faces:]])
        assert np.abs((jump * network.normals).sum(1)).max() < found.rounding
        assert np.abs(M_n @ (jump * network.tangents).sum(1)).max() < 10 * found.rounding


@pytest.mark.parametrize(
    "network", [triangle(), rhombus(), bowtie(), ring(5), wheel(3), wheel(4), wheel(6)],
    ids=lambda network: network.name,
)  # fmt: skip
def test_small_networks_have_as_many_as_frictionless_self_stresses(network):
    """Exact: one for every wheel, none for the others; no outer face, so no constants."""
    Q = ExactField(network).matrix(network.Q)
    assert Q.shape[0] - Q.rank() == null_space(network, frictional=False).cols
    assert (Q.shape[0] > Q.rank()) == network.name.startswith("wheel")
