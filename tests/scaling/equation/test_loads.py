"""Loads that contacts cannot balance are refused by every method, right ones by none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaling import ContactNetwork, force_equation, perturb, reconstruct, relative_error
from scaling.equation.loads import refuse_unbalanced
from scaling.equation.mechanisms import refuse_mechanisms
from tests.conftest import packing
from tests.properties.strategies import clusters
from tests.scaling.networks import loaded, triangle
from tests.scaling.packings import network_of
from tests.scaling.real_packings import box

METHODS = ("gppsz", "direct", "transverse", "balanced", "optimal", "bounded")
FORMATS = ("%.17g", "%.6g", "%.5f", "%.8e")


def region(p, share=0.4):
    """The middle of a packing without grains left alone on one contact, and its forces."""
    x, sides = p.positions, p.cell.sum(axis=0)
    mask = np.linalg.norm(x - sides / 2, axis=1) < share * p.cell[0, 0]
    while True:
        inner = p.pairs[mask[p.pairs].all(axis=1)]
        lonely = mask & (np.bincount(inner.ravel(), minlength=len(mask)) < 2)
        if not lonely.any():
            break
        mask &= ~lonely
    f = p.forces.reshape(2, -1)
    part = network_of(p).inside(mask, *f)
    return part, f[:, part.contact_index].ravel()


def asked(method, n, forces):
    more: dict = {}
    if method == "transverse":
        more["normal_forces"] = forces[: n.contacts]
    if method in ("optimal", "bounded"):
        more["xi"] = 1e-5
    if method == "bounded":
        pytest.importorskip("clarabel")
        more["friction"] = 0.4
    return more


def with_loads(n, external):
    return n.with_sizes(n.radii, external)


def written(values, how):
    return np.vectorize(lambda v: float(how % v))(values)


@pytest.mark.filterwarnings("ignore::scaling.estimators.misfit.ImplausibleNoiseWarning")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("delta", [1e-2, 1e-4, 1e-6])
def test_loads_at_the_rim_of_a_region_pass_and_fewer_are_refused(method, delta):
    """A region cut out of a packing. Negative control: the same with one load dropped, whichever,
    or with none left."""
    part, forces = region(packing(grains=100, delta=delta, seed=3))
    more = asked(method, part, forces)
    found = reconstruct(part, 1.0, method, **more)
    assert relative_error(found.forces, forces, frictional=True) < 1e-6
    assert found.imbalance < 1e-6
    for grain in np.flatnonzero(part.external.any(axis=1))[:: 6 if method == "bounded" else 2]:
        fewer = part.external.copy()
        fewer[grain] = 0
        with pytest.raises(ValueError, match=r"loads cannot be balanced: .* add up to"):
            reconstruct(with_loads(part, fewer), 1.0, method, **more)


@given(seed=st.integers(0, 9), grains=st.sampled_from([36, 48, 64]), how=st.sampled_from(FORMATS))
def test_rounded_loads_pass(seed, grains, how):
    """Forces rounded before the cut, or loads rounded after it; the control drops a load larger
    than what is rounded."""
    p = packing(grains=grains, delta=1e-3, seed=seed % 4)
    f = p.forces.reshape(2, -1)
    scale = f[0].mean()  # of order one, as decimals are for numbers of order one
    rng = np.random.default_rng(seed)
    inner = np.linalg.norm(p.positions - p.positions[rng.integers(grains)], axis=1) < 2.2
    part = network_of(p).inside(inner, *written(f / scale, how))
    whole = network_of(p).inside(inner, *(f / scale))
    if not part.contacts or (whole.external.any(axis=1) & (whole.degrees < 2)).any():
        return
    for n in (part, with_loads(whole, written(whole.external, how))):
        equation = force_equation(n)
        refuse_unbalanced(equation)
        refuse_mechanisms(equation)
    dropped = part.external.copy()
    dropped[np.argmax(np.hypot(*dropped[:, :2].T))] = 0
    with pytest.raises(ValueError, match="add up to"):
        refuse_unbalanced(force_equation(with_loads(part, dropped)))


@given(truth=clusters(), noise=st.sampled_from(["diameter", "position"]), seed=st.integers(0, 99))
def test_loads_of_clusters_pass_with_noise_of_any_size(truth, noise, seed):
    """Loads known exactly, sizes or positions noisy: they do not balance in the directions that
    were measured, and are right all the same."""
    for ξ in (1e-6, 1e-3, 0.03):
        try:
            noisy = perturb(truth.network, ξ, np.random.default_rng(seed), noise)
        except ValueError:  # a radius that would be negative
            continue
        equation = force_equation(noisy)
        refuse_unbalanced(equation)
        refuse_mechanisms(equation)


@pytest.mark.parametrize("method", ["gppsz", "direct", "transverse", "balanced"])
def test_a_box_of_another_code_without_its_walls(method):
    """Grains under their weight, walls forgotten: Σ F is the weight of all."""
    lammps = box()
    n, weight = lammps.network, np.zeros((168, 3))
    weight[:, 1] = -lammps.masses
    more = asked(method, n, lammps.forces)
    reconstruct(n, lammps.stiffness, method, **more)
    message = rf"add up to \(0, -{lammps.masses.sum():.4g}\).*forces of walls"
    with pytest.raises(ValueError, match=message):
        reconstruct(lammps.loaded(weight), lammps.stiffness, method, **more)
    without_torques = np.array(n.external)
    without_torques[:, 2] = 0
    with pytest.raises(ValueError, match=r"net torque .* torques of walls"):
        reconstruct(lammps.loaded(without_torques), lammps.stiffness, method, **more)


@pytest.mark.filterwarnings("ignore::scaling.CoarseCoordinatesWarning")
@pytest.mark.parametrize("how", ["%.6g", "%.5f"])
def test_a_box_written_with_few_digits(how):
    """The whole file rounded: the loads are right to its digits. Without walls they are not."""
    lammps = box()
    n = lammps.network
    external = written(n.external, how)
    rounded = ContactNetwork(
        written(n.positions, how), written(n.radii, how), n.pairs, external=external
    )
    reconstruct(rounded, lammps.stiffness)
    external[:, :2] = 0
    external[:, 1] = -lammps.masses
    with pytest.raises(ValueError, match="add up to"):
        reconstruct(with_loads(rounded, external), lammps.stiffness)


def test_a_net_force_on_what_winds_is_refused():
    """Round a torus nothing can hold a net force: nor does a ribbon, in either direction."""
    p = packing()
    n = network_of(p)
    pushed = np.zeros((n.grains, 3))
    i, j = p.pairs[0]
    pushed[i, :2], pushed[j, :2] = (1e-4, 2e-4), (-1e-4, -1e-4)
    with pytest.raises(ValueError, match=r"wound in both directions\) add up to \(0, 0\.0001\)"):
        reconstruct(with_loads(n, pushed), 1.0)
    pushed[j, 1] = -2e-4  # a pair: a torque is no matter there
    reconstruct(with_loads(n, pushed), 1.0)
    # Two rows of a square lattice that meet themselves along x: a ribbon.
    x = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
    pairs = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5), (0, 4)]
    images = np.zeros((10, 2), dtype=int)
    images[[2, 5], 0] = -1
    ribbon = ContactNetwork(x, [0.51] * 6, pairs, cell=[[3, 0], [0, 9]], images=images)
    assert ribbon.forest.winding_rank.max() == 1
    for axis in (0, 1):
        external = np.zeros((6, 3))
        external[4, axis] = 1e-3
        with pytest.raises(ValueError, match="wound in one direction"):
            reconstruct(with_loads(ribbon, external), 1.0, "direct")


@pytest.mark.filterwarnings("ignore::scaling.estimators.misfit.ImplausibleNoiseWarning")
@pytest.mark.parametrize("method", METHODS[:-1])
def test_a_grain_that_dangles_cannot_bear_a_load_across(method):
    """A triangle with a fourth grain on its tip: along the contact a load passes, across not."""
    n = triangle(radius=0.505)
    tip = n.positions[2]
    for up in (np.array([0, 1.0]), np.array([1.0, 0])):  # along the contact, and across
        x = np.vstack([n.positions, tip + np.array([0, 1.0])])
        external = np.zeros((4, 3))
        external[3, :2] = -0.01 * up
        external[:2, :2] = 0.005 * up
        if up[0]:  # a torque of the two at the bottom balances the moment
            h = x[3, 1]
            external[:2, 1] += 0.01 * h * np.array([1.0, -1.0])
        hung = ContactNetwork(x, [0.505] * 4, [*map(tuple, n.pairs), (2, 3)], external=external)
        more = asked(method, hung, np.full(8, 0.01))
        if not up[0]:
            refuse_unbalanced(force_equation(hung))
            reconstruct(hung, 1.0, method, **more)
            continue
        with pytest.raises(ValueError, match=r"grains \(3.*on grain 3, which has 1 contact;"):
            reconstruct(hung, 1.0, method, **more)


def chain(bend):
    """Three disks pressed together at the ends, the middle one displaced by `bend`."""
    x = np.array([[0, 0], [1, bend], [2, 0]])
    external = [[0.02, 0, 0], [0, 0, 0], [-0.02, 0, 0]]
    return ContactNetwork(x, [0.51] * 3, [(0, 1), (1, 2)], external=external)


@pytest.mark.parametrize("frictional", [True, False])
def test_a_chain_carries_what_is_along_it(frictional):
    for method in ("direct", "balanced"):
        found = reconstruct(chain(0.0), 1.0, method, frictional=frictional)
        np.testing.assert_allclose(found.normal, 0.02, rtol=1e-12)
        with pytest.raises(ValueError, match="a chain that bends"):
            reconstruct(chain(0.3), 1.0, method, frictional=frictional)


def test_a_frictionless_grain_between_two_cannot_be_pushed_aside():
    """A square of four with a load across one contact in the middle of its side, which only
    friction could carry; pushed along the sides it stands."""
    x = [[0, 0], [1, 0], [2, 0], [0, -1.0], [1, -1.0], [2, -1.0]]
    pairs = [(0, 1), (1, 2), (3, 4), (4, 5), (0, 3), (2, 5)]
    along, across = np.zeros((6, 3)), np.zeros((6, 3))
    along[0, 0], along[2, 0] = 0.01, -0.01
    across[1, 1], across[[0, 2], 1] = 0.01, -0.005
    n = ContactNetwork(x, [0.51] * 6, pairs, external=along)
    reconstruct(n, 1.0, "direct", frictional=False)
    with pytest.raises(ValueError, match=r"on grain 1, which has 2 contacts"):
        reconstruct(with_loads(n, across), 1.0, "direct", frictional=False)


def test_mechanisms_far_apart_are_found_in_a_large_packing():
    """A load across on each of three dangling grains is named among a thousand right rows."""
    p = packing(grains=300, delta=1e-3)
    n = network_of(p)
    x, radii = list(n.positions), list(n.radii)
    pairs, images, external = list(n.pairs), list(n.images), [np.zeros(3)] * n.grains
    for k, host in enumerate(n.active[[10, 100, 200]]):
        r = n.radii[host]
        x.append(n.positions[host] + [0, 2 * r])
        radii.append(r)
        pairs.append((host, n.grains + k))
        images.append((0, 0))
        external.append(np.array([p.pressure, 0, 0]))
        external[host] = np.array([-p.pressure, 0, -2 * r * p.pressure])
    hung = ContactNetwork(x, radii, pairs, cell=n.cell, images=images, external=external)
    equation = force_equation(hung)
    refuse_unbalanced(equation)
    names = {str(n.grains + k) for k in range(3)}
    with pytest.raises(ValueError, match="bear a part that no contact forces balance") as refused:
        refuse_mechanisms(equation)
    listed = str(refused.value).split("grains (")[1].split(")")[0].rstrip(".").split(", ")
    assert names <= set(listed)


def test_imbalance_is_reported_over_the_mean_normal_force():
    """`direct` with noise does not balance, by ξ/Δ; exact data do, to rounding."""
    p = packing(delta=1e-3)
    n = network_of(p)
    for method in ("gppsz", "direct", "balanced"):
        assert reconstruct(n, 1.0, method).imbalance < 1e-10
    noisy = perturb(n, 1e-3, np.random.default_rng(0))
    found = reconstruct(noisy, 1.0, "direct")
    equation = force_equation(noisy)
    rows = equation.M @ found.forces - equation.balance_rhs()
    assert found.imbalance == pytest.approx(abs(rows).max() / abs(found.normal).mean())
    assert 0.1 < found.imbalance < 10
    assert reconstruct(noisy, 1.0, "balanced").imbalance < 1e-9


def test_a_scene_without_loads_is_not_looked_at(monkeypatch):
    def never(*_):
        raise AssertionError("nothing to look at")

    monkeypatch.setattr("scaling.equation.loads.strain_of", never)
    assert reconstruct(network_of(packing()), 1.0).residual < 1e-12


def test_directions_alone_tell_as_much():
    """Without positions the places follow from sizes and directions."""
    truth = loaded(triangle(radius=0.505))
    n = truth.network
    blind = ContactNetwork(None, n.radii, n.pairs, normals=n.normals, external=n.external)
    reconstruct(blind, 1.0)
    turned = n.external.copy()
    turned[:, 2] += 0.01
    with pytest.raises(ValueError, match="net torque"):
        reconstruct(with_loads(blind, turned), 1.0)
