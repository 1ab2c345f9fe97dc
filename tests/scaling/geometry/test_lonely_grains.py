"""A grain all of whose contacts were cut balances by itself: what rounding leaves is no load."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, perturb, reconstruct
from tests.conftest import packing
from tests.scaling.packings import network_of


def star(tilt, strength=0.1):
    """Grain 0 between three that push alike, turned by `tilt`, and a triangle apart."""
    a = np.deg2rad([10, 130, 250]) + tilt
    around = np.column_stack([np.cos(a), np.sin(a)])
    x = np.vstack([[0, 0], around, [[9, 0], [10, 0], [9.5, 0.87]]])
    pairs = [[0, 1], [0, 2], [0, 3], [4, 5], [4, 6], [5, 6]]
    n = ContactNetwork(x, [0.5] * 7, pairs)
    return n, np.array([strength] * 3 + [0.0] * 3)


@pytest.mark.parametrize("strength", [1e-12, 0.1, 1e9])
def test_what_rounding_leaves_of_balanced_forces_is_removed(strength):
    """For any direction and any unit. The control: a load on the same grain, and forces that do
    not balance, a part in a million, stay and are refused."""
    rest = 0
    for tilt in np.linspace(0, 2, 20):
        n, f = star(tilt, strength)
        part = n.inside([0, 4, 5, 6], f)
        rest += int(abs(f[:3] @ n.normals[:3]).max() > 0)
        assert not part.external.any()
        reconstruct(part, 1.0)
        f[0] *= 1 + 1e-6
        unbalanced = n.inside([0, 4, 5, 6], f)
        with pytest.raises(ValueError, match=r"grain 0 has a load .* but no contact"):
            reconstruct(unbalanced, 1.0)
    assert rest > 10  # rounding did leave something
    external = np.zeros((7, 3))
    external[0, 2] = 1e-3 * strength
    loaded = n.with_sizes(n.radii, external).inside(
        [0, 4, 5, 6], np.array([strength] * 3 + [0] * 3)
    )
    with pytest.raises(ValueError, match="grain 0 has a load"):
        reconstruct(loaded, 1.0)


@pytest.mark.parametrize("delta", [1e-2, 1e-6])
@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_lonely_grains_of_packings(delta, friction):
    """Regions without neighbours in common, of balanced packings: grains left alone bear nothing,
    to the digits that forces of overlaps have at this Δ."""
    p = packing(grains=64, delta=delta, friction=friction)
    n = network_of(p)
    f = p.forces.reshape(-1, n.contacts)
    bearing, lonely = n.active, 0
    for grain in bearing[::5]:
        apart = np.setdiff1d(bearing, [grain, *n.pairs[(n.pairs == grain).any(axis=1)].ravel()])
        part = n.inside(np.r_[grain, apart], *f)
        lonely += int(part.degrees[grain] == 0)
        assert not part.external[grain].any()
        force_equation(part, friction > 0)
    assert lonely == len(bearing[::5])


def test_contacts_that_cross_matter_to_loops_alone():
    """The two diagonals of a square: methods without loops, and noise on positions, take them;
    `gppsz` names them."""
    x = 0.95 * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    pairs = [(0, 1), (1, 2), (2, 3), (0, 3), (0, 2), (1, 3)]
    n = ContactNetwork(x, [0.6] * 4, pairs)
    equation = force_equation(n)
    f = np.concatenate([n.overlaps, np.zeros(6)])
    rows = -(equation.M @ f).reshape(3, -1).T
    crossed = n.with_sizes(n.radii, rows * [1, 1, 0.6])
    assert abs(reconstruct(crossed, 1.0, "direct").forces - f).max() < 1e-12
    moved = perturb(crossed, 1e-3, np.random.default_rng(0), "position")
    found = reconstruct(moved, 1.0, "direct")
    assert 0 < abs(found.forces - f).max() < 0.02
    with pytest.raises(ValueError, match="contacts cross"):
        reconstruct(crossed, 1.0)
    pytest.importorskip("clarabel")
    more = {"xi": 0.1, "noise": "position", "friction": 0.5}
    assert reconstruct(moved, 1.0, "bounded", **more).normal.min() > -1e-7
