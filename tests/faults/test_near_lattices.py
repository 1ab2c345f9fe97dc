"""Square lattices with a little disorder: ill-conditioned, of full rank. Right, or refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

from packing.arguments.arrays import Floats, Integers
from scaling import ContactNetwork, force_equation, gain, reconstruct
from scaling.noise.conventions import size_response


def square(n: int, disorder: float, rng: np.random.Generator) -> tuple[Floats, Integers]:
    """(positions, contacts as pair and image) of n × n grains moved by `disorder`."""
    x = np.array([[i, j] for i in range(n) for j in range(n)], float)
    e = [
        (i * n + j, (i + a) % n * n + (j + b) % n, (i + a) // n, (j + b) // n)
        for i in range(n)
        for j in range(n)
        for a, b in ((1, 0), (0, 1))
    ]
    ordered = [(u, v, p, q) if u < v else (v, u, -p, -q) for u, v, p, q in e]
    return x + disorder * rng.normal(size=(n * n, 2)), np.array(ordered)


def test_balanced_forces_of_exact_data():
    """Condition 5e6: the forces are known to 1e-9 by dense algebra, and to 1e-3 at worst here."""
    rng = np.random.default_rng(0)
    x, e = square(6, 1e-6, rng)
    R = 0.5 + 1e-2 * rng.uniform(0, 1, 36)
    given = {"cell": np.eye(2) * 6, "images": e[:, 2:]}
    network = ContactNetwork(x, R, e[:, :2], **given)
    f = np.r_[network.overlaps, 1e-2 * rng.normal(size=len(e))]
    unit = np.column_stack([np.ones((36, 2)), R])
    F = -(force_equation(network).M @ f).reshape(3, -1).T * unit
    loaded = ContactNetwork(x, R, e[:, :2], external=F, **given)
    found = reconstruct(loaded, 1.0, "balanced")
    error = np.linalg.norm(found.forces - f) / np.linalg.norm(f)
    assert error <= 1e-3
    assert error <= 10 * found.error_estimate


def test_gain_of_balanced():
    """K by the null space of M, dense: 0.6594."""
    rng = np.random.default_rng(0)
    x, e = square(4, 1e-5, rng)
    R = 0.5 + 1e-2 * rng.uniform(0, 1, 16)
    network = ContactNetwork(x, R, e[:, :2], cell=np.eye(2) * 4, images=e[:, 2:])
    q = force_equation(network)
    Z = null_space(q.M.toarray(), rcond=1e-11)
    of_noise = (q.Q @ size_response(network, "diameter")).toarray()
    E = Z @ np.linalg.pinv(q.matrices.closure.toarray() @ Z, rcond=1e-14) @ of_noise
    right = np.linalg.norm(E) / np.sqrt(q.unknowns)
    assert gain(network, "balanced") == pytest.approx(right, rel=1e-2)
    assert right == pytest.approx(0.6594, rel=1e-3)


def test_lsmr_of_condition_5e8():
    """Dense algebra finds the forces to 1e-8; an iteration that stops early misses all of it."""
    x, e = square(20, 1e-8, np.random.default_rng(0))
    network = ContactNetwork(
        x, np.full(400, 0.505), e[:, :2], cell=np.eye(2) * 20, images=e[:, 2:]
    )
    q = force_equation(network)
    f = np.random.default_rng(1).normal(size=q.unknowns)
    found = q.matrices.system.solve(q.G @ f, "lsmr")
    assert np.linalg.norm(found - f) / np.linalg.norm(f) <= 1e-5


@pytest.mark.parametrize("solver", ["dense", "factor", "lsmr"])
def test_a_matrix_of_zeros_has_rank_0(solver):
    """One grain that touches its own images, without friction: G = 0."""
    network = ContactNetwork(
        [[0, 0]], [0.51], [[0, 0], [0, 0]], cell=np.eye(2), images=[[1, 0], [0, 1]]
    )
    with pytest.raises(ValueError, match="rank 0 of 2 unknowns"):
        reconstruct(network, 1.0, frictional=False, solver=solver)
