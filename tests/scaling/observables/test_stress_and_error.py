"""The stress tensor and the error measure, by hand."""

import numpy as np
import pytest

from scaling import ContactNetwork, relative_error, stress
from tests.scaling.networks import lattice, loaded, periodic, triangle

EPS = np.finfo(float).eps


def test_square_lattice_by_hand():
    """Springs along x carry 2, along y 3, over length 1 each: σ = diag(2, 3), p = 2.5."""
    n = lattice("square", 3)
    along_x = abs(n.normals[:, 0]) > 0.5
    np.testing.assert_allclose(stress(n, np.where(along_x, 2.0, 3.0)), np.diag([2, 3]), atol=1e-14)


def test_shear_stress_from_tangential_forces_by_hand():
    """f_t = 1 on contacts along x pushes j towards -y: σ_xy = -1. Along y, t = -x: σ_yx = +1."""
    n = lattice("square", 3)
    along_x = abs(n.normals[:, 0]) > 0.5
    f = np.concatenate([np.zeros(18), np.where(along_x, 1.0, 0.0)])
    np.testing.assert_allclose(stress(n, f), [[0, -1], [0, 0]], atol=1e-14)
    f = np.concatenate([np.zeros(18), np.where(along_x, 0.0, 1.0)])
    np.testing.assert_allclose(stress(n, f), [[0, 0], [1, 0]], atol=1e-14)


def test_pressure_is_the_trace_and_does_not_depend_on_the_cell():
    truth = loaded(periodic())
    n = truth.network
    p = truth.normal @ n.distances / (2 * abs(np.linalg.det(n.cell)))
    np.testing.assert_allclose(stress(n, truth.forces).trace() / 2, p, rtol=20 * EPS)
    other = ContactNetwork(
        n.positions,
        n.radii,
        n.pairs,
        cell=np.array([[1, 0], [1, 1]]) @ n.cell,
        images=n.images @ np.array([[1, 0], [-1, 1]]),
    )
    np.testing.assert_allclose(stress(other, truth.forces), stress(n, truth.forces), rtol=1e-12)


def test_loads_and_contacts_say_the_same():
    """Open, in balance: Σ_e r_e n_a f_b on j = -Σ_i x_a F_b over the loads."""
    n = triangle()
    truth = loaded(n.with_sizes(1.1 * n.radii))
    from_loads = -truth.network.positions.T @ truth.network.external[:, :2]
    np.testing.assert_allclose(
        stress(truth.network, truth.forces, area=2.0), from_loads / 2.0, atol=10 * EPS
    )


def test_area_is_asked_for_where_it_is_needed():
    n = triangle()
    with pytest.raises(ValueError, match="no area of its own"):
        stress(n, np.ones(6))
    with pytest.raises(ValueError, match=r"area = -1\.0"):
        stress(n, np.ones(6), area=-1.0)
    with pytest.raises(ValueError, match=r"area = 2\.0 is not used"):
        stress(periodic(), np.ones(75), area=2.0)
    with pytest.raises(ValueError, match="5 forces for 3 contacts: expected 3 or 6"):
        stress(n, np.ones(5), area=1.0)
    blind = ContactNetwork(None, n.radii, n.pairs, normals=n.normals)
    with pytest.raises(ValueError, match="distances need positions"):
        stress(blind, np.ones(3), area=1.0)


def test_error_by_hand():
    """True (3, 4) and (0, 0) → mean |f| = 2.5; off by 1 in one of four components: rms ½."""
    true = [3, 0, 4, 0]  # f_n = 3, 0; f_t = 4, 0
    np.testing.assert_allclose(
        relative_error([3, 1, 4, 0], true, frictional=True), 0.5 / 2.5, rtol=4 * EPS
    )
    # As normal forces of four contacts: mean 7/4.
    np.testing.assert_allclose(
        relative_error([3, 1, 4, 0], true, frictional=False), 0.5 / 1.75, rtol=4 * EPS
    )


@pytest.mark.parametrize(
    ("predicted", "true", "message"),
    [
        ([1, 2, 3], [1, 2, 3], "3 forces are not normal and tangential ones"),
        ([1, 2], [1, 2, 3, 4], r"shape \(2,\), the true ones \(4,\)"),
        ([0, 0], [0, 0], "mean true force is 0"),
        ([1, 1], [1, np.nan], r"true\[1\] \(component 1\) is nan"),
        ([np.inf, 1], [1, 1], r"predicted\[0\] \(component 0\) is inf"),
        ([], [], r"true has shape \(0,\)"),
    ],
)
def test_bad_forces_are_refused(predicted, true, message):
    with pytest.raises(ValueError, match=message):
        relative_error(predicted, true, frictional=True)


def test_stress_of_too_few_forces_is_refused():
    n = triangle(0.99)
    with pytest.raises(ValueError, match="2 forces for 3 contacts: expected 3 or 6"):
        stress(n, np.ones(2), area=1.0)


def test_true_forces_that_vanish_beside_the_difference_are_refused():
    """Not infinite: the ratio overflows, and no such packing is known. The control is finite."""
    found = np.full(6, 1e-2)
    with pytest.raises(ValueError, match=r"the mean true force is 1.41e-202 .* beyond 1e\+140"):
        relative_error(found, np.full(6, 1e-202), frictional=True)
    assert relative_error(found, np.full(6, 1e-100), frictional=True) < 1e140
