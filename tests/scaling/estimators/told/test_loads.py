"""Loads as data with a covariance, and grains whose balance is not required."""

from __future__ import annotations

import numpy as np
import pytest

from packing.boundary import Walls
from scaling import ContactNetwork, error_map, force_equation, perturb, reconstruct, relative_error
from scaling.estimators import Bounded
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.told.loads import load_errors
from tests.conftest import packing
from tests.scaling.packings import network_of
from tests.scaling.worlds import packing_in

XI = 3e-4
METHODS = ("optimal", "bounded")
ALL = {"gppsz": {}, "direct": {}, "balanced": {}, "optimal": {"xi": 1e-9, "noise": "position"}}


def region():
    """A disc cut out of a packing, with all contacts of its grains: other ends are outer grains,
    loaded by what else touches them. (packing, network, true forces, outer grains)."""
    p = packing(grains=200, delta=1e-3)
    n = network_of(p)
    x = p.positions - p.positions.mean(axis=0)
    mask = np.hypot(*x.T) < 0.4 * np.sqrt(abs(np.linalg.det(p.cell)))
    keep = mask[n.pairs].any(axis=1)
    f = p.forces[np.tile(keep, 2)]
    bare = n.selected(keep, np.zeros((n.grains, 3))).unwrapped()
    rows = (force_equation(bare).M @ f).reshape(3, -1)
    external = np.zeros((n.grains, 3))
    external[bare.active] = -rows.T
    external[:, 2] *= n.radii
    external[mask] = 0.0
    return p, bare.replaced(external=external), f, (bare.degrees > 0) & ~mask


def noisy_region(wrong=0.0, seed=1):
    """The same with noisy positions, loads that are off by `wrong` times their rms, and that."""
    p, part, f, outer = region()
    size = np.sqrt(np.mean(part.external[outer, :2] ** 2))
    off = np.random.default_rng(seed).standard_normal(part.external.shape) * outer[:, None]
    off[:, 2] *= part.radii
    noisy = perturb(part, XI, np.random.default_rng(3), "position")
    loads = part.external + wrong * size * off
    return p, noisy.replaced(external=loads), f, outer, size


def solved(network, p, method, **more):
    more = ({"friction": p.friction} if method == "bounded" else {}) | more
    return reconstruct(network, p.stiffness, method, xi=XI, noise="position", **more)


def apart(n):
    """A dozen grains of which no two touch."""
    free = np.zeros(n.grains, dtype=bool)
    for i in range(n.grains):
        near = n.pairs[(n.pairs == i).any(axis=1)]
        if len(near) and not free[near].any() and free.sum() < 12:
            free[i] = True
    return free


@pytest.mark.parametrize("method", METHODS)
def test_a_load_is_exact_without_error_and_not_told_with_an_infinite_one(method):
    """As the error bar goes to 0 the exact answer, as it goes to ∞ that of grains whose balance is
    not required; in between (the control) neither."""
    p, network, _, outer, size = noisy_region()
    exact = solved(network, p, method).forces
    nothing = solved(network, p, method, free=outer).forces
    scale = np.sqrt(np.mean(exact**2))
    strong = solved(network, p, method, loads=1e-7 * size).forces
    weak = solved(network, p, method, loads=1e6 * size).forces
    middle = solved(network, p, method, loads=0.1 * size).forces
    assert strong == pytest.approx(exact, abs=1e-5 * scale)
    assert weak == pytest.approx(nothing, abs=1e-4 * scale)
    for end in (exact, nothing):
        assert abs(middle - end).max() > 1e-3 * scale


def test_sizes_take_loads_with_error_bars_too():
    """data="sizes": the same two limits, for noise on diameters."""
    p = packing(grains=100, delta=1e-3)
    n = network_of(p)
    free = apart(n)
    noisy = perturb(n, XI, np.random.default_rng(3))

    def forces(**more):
        return reconstruct(noisy, p.stiffness, "optimal", xi=XI, data="sizes", **more).forces

    exact, nothing = forces(), forces(free=free)
    sd, scale = np.repeat(free[:, None], 3, axis=1).astype(float), np.sqrt(np.mean(exact**2))
    assert forces(loads=1e-7 * scale * sd) == pytest.approx(exact, abs=1e-4 * scale)
    assert forces(loads=1e6 * scale * sd) == pytest.approx(nothing, abs=1e-4 * scale)
    assert abs(exact - nothing).max() > 1e-3 * scale


@pytest.mark.parametrize("method", METHODS)
def test_loads_that_are_off_are_mended_where_their_error_is_told(method):
    """Off by a tenth of themselves they do not balance: told as exact (the control) refused, told
    with their error used."""
    p, network, f, _, size = noisy_region(wrong=0.1)
    with pytest.raises(ValueError, match="loads cannot be balanced"):
        solved(network, p, method)
    found = solved(network, p, method, loads=0.1 * size)
    assert relative_error(found.forces, f, frictional=True) < 0.3
    told = found.diagnostics.loads
    assert told is not None
    wrong = force_equation(network).balance_rhs()
    true = force_equation(region()[1]).balance_rhs()
    assert np.linalg.norm(told - true) < 0.9 * np.linalg.norm(wrong - true)
    with pytest.raises(ValueError, match="its error as told"):
        solved(network, p, method, loads=1e-4 * size)


@pytest.mark.parametrize("method", METHODS)
def test_turned_and_relabelled_loads_give_turned_forces(method):
    """A correlated covariance turns with the loads; numbers of grains are names."""
    p, network, _, outer, size = noisy_region(wrong=0.05)
    N, rng = network.grains, np.random.default_rng(5)
    L = 0.05 * size * (np.eye(3 * N) + 0.3 * rng.standard_normal((3 * N, 3 * N)) / np.sqrt(N))
    L *= np.tile(outer, 3)[:, None]
    angle, name = 0.7, rng.permutation(N)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    of_loads = np.kron(np.block([[turn, np.zeros((2, 1))], [np.zeros((1, 2)), 1]]), np.eye(N))
    here = solved(network, p, method, loads=L @ L.T)

    def named(rows):
        out = np.empty_like(rows)
        out[name] = rows
        return out

    rows = np.concatenate([name, N + name, 2 * N + name])
    turned = of_loads @ L
    moved = np.empty_like(turned)
    moved[rows] = turned
    F = network.external @ np.block([[turn.T, np.zeros((2, 1))], [np.zeros((1, 2)), 1]])
    pairs = name[network.pairs]
    flip = pairs[:, 0] > pairs[:, 1]
    pairs[flip] = pairs[flip][:, ::-1]
    other = ContactNetwork(
        named(network.positions @ turn.T), named(network.radii), pairs, external=named(F)
    )
    there = solved(other, p, method, loads=moved @ moved.T)
    assert there.forces == pytest.approx(here.forces, abs=1e-5 * here.forces.max())
    alone = np.diag(moved @ moved.T)  # the control: the same variances without correlation
    same = solved(other, p, method, loads=alone)
    assert abs(same.forces - here.forces).max() > 1e-3 * here.forces.max()


def test_a_wrong_error_of_the_loads_loses_optimality():
    """The variance of linear estimates, exactly: of loads with the deviation d, weighed as if it
    were d/30 or 30 d (the controls), against weighed as it is."""
    p, network, _, _, size = noisy_region()
    d = 0.02 * size

    def variance(said):
        found = solved(network, p, "optimal", loads=said)
        model = found.response.noise
        squares = np.concatenate(
            [np.sum(some.values**2, axis=0) for _, some in found.response.columns()]
        )
        squares[model.count - model.aside :] *= (d / said) ** 2
        return squares.sum()

    best = variance(d)
    assert variance(d / 30) > 1.01 * best
    assert variance(30 * d) > 1.01 * best


def test_standard_errors_count_the_error_of_the_loads():
    """The response to the source of a load is what another load told does."""
    p, network, _, outer, size = noisy_region()
    d, i = 1e-3 * size, int(np.flatnonzero(outer)[0])
    sd = np.zeros((network.grains, 3))
    sd[outer] = d
    one = solved(network, p, "optimal", loads=sd)
    F = network.external.copy()
    F[i, 0] -= d
    other = solved(network.replaced(external=F), p, "optimal", loads=sd)
    model = one.response.noise
    first = model.count - model.aside
    row = force_equation(network).matrices.active.tolist().index(i)
    of_source = np.flatnonzero(model.loads[[row]].toarray().ravel())[0]
    ζ = np.zeros((model.count, 1))
    ζ[first + of_source] = 1.0
    δ = one.diagnostics.scale * one.response(ζ).ravel()
    assert other.forces - one.forces == pytest.approx(-δ, abs=0.1 * abs(δ).max())


def test_draws_have_the_loads_with_their_error():
    """Loads drawn scatter as told where nothing else tells them: forces of one contact."""
    pair = ContactNetwork(
        [[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=[[1.0, 0, 0], [-1.0, 0, 0]]
    )
    estimator = Bounded(friction=0.3, xi=10.0, loads=0.02)
    problem = estimator.posterior(force_equation(pair).with_law(10.0))
    f = posterior_draws(problem, np.random.default_rng(0), 60, progress=False)[:, 0]
    sd = 0.02 / np.sqrt(2)  # the mean of two loads
    assert f.mean() == pytest.approx(1, abs=6 * sd / np.sqrt(60))
    assert 0.3 < f.var() / sd**2 < 2.5  # 59 degrees: beyond e^-20 either side


@pytest.mark.parametrize("method", [*ALL, "bounded"])
def test_free_grains_leave_exact_data_exact_whatever_their_loads(method):
    """As `inside` with the forces of the cut; without `free` (the control) wrong loads are refused
    or do harm."""
    p = packing(grains=100, delta=1e-3)
    n, more = network_of(p), ALL.get(method, {})
    if method == "bounded":
        more = {"xi": 1e-6, "noise": "position", "friction": p.friction}
    free = apart(n)
    wrong = n.replaced(external=np.outer(free, [1.0, -2.0, 0.5]) * p.pressure)
    found = reconstruct(wrong, p.stiffness, method, free=free, **more)
    assert relative_error(found, p) < 1e-3
    if method == "bounded":
        more = more | {"pressure": p.pressure}
    with pytest.raises(ValueError, match=r"cannot be balanced|with loads"):
        reconstruct(wrong, p.stiffness, method, **more)


def test_the_forces_found_across_a_cut_are_the_loads_that_inside_needs():
    """`transverse` with free outer grains, and of the inner grains alone, loaded by what it
    found."""
    _, part, f, outer = region()
    c = part.contacts
    network = part.freed(outer)
    found = reconstruct(network, None, "transverse", normal_forces=f[:c])
    inner = part.inside(~outer & (part.degrees > 0), found.normal, found.tangential)
    again = reconstruct(inner, None, "transverse", normal_forces=found.normal[inner.contact_index])
    assert again.tangential == pytest.approx(
        found.tangential[inner.contact_index], abs=1e-8 * f.max()
    )
    assert abs(force_equation(network).M @ found.forces).max() < 1e-8 * f.max()


def test_free_grains_stay_free():
    """Noise, selection and other loads do not bind them; counts are those of the rank."""
    _, part, _, outer = region()
    network = part.freed(outer)
    for other in (
        perturb(network, 1e-3, np.random.default_rng(0), "position"),
        network.without_rattlers(),
        network.replaced(external=np.zeros_like(network.external)),
        network.unwrapped(),
    ):
        assert (other.free == outer).all()
        assert not outer[other.active].any()
    assert not part.free.any()
    equation = force_equation(network)
    touching = network.with_sizes(network.radii)  # rank at finite Δ: moments of parts count
    rank = np.linalg.matrix_rank(force_equation(touching).M.toarray(), tol=1e-9)
    assert equation.hyperstaticity == equation.unknowns - rank


def test_what_free_grains_leave_open_is_refused_by_name():
    p, part, _, outer = region()
    whole, smooth = network_of(p), part.replaced(external=np.zeros_like(part.external))
    i, j = whole.pairs[0]
    for method, more in ALL.items():
        with pytest.raises(ValueError, match=f"contact 0 joins grains {i} and {j}, both free"):
            reconstruct(whole, p.stiffness, method, free=[i, j], **more)
    with pytest.raises(ValueError, match="asks no balance"):
        reconstruct(smooth, p.stiffness, "direct", frictional=False, free=outer)
    with pytest.raises(ValueError, match="which therefore is no datum"):
        reconstruct(whole, p.stiffness, "bounded", friction=0.3, pressure=1.0, xi=XI, free=[0])
    with pytest.raises(ValueError, match="tell the scale of the forces"):
        reconstruct(whole, p.stiffness, "bounded", friction=0.3, xi=np.inf, free=[0])
    with pytest.raises(ValueError, match="free names grain 200 of 200"):
        whole.freed([200])
    with pytest.raises(ValueError, match="free leaves no grain"):
        whole.freed(np.ones(200, dtype=bool))


@pytest.mark.parametrize(
    ("told", "message"),
    [
        (-1.0, "loads = -1.0"),
        (np.ones(5), r"loads has shape \(5,\)"),
        (np.full((200, 3), -1.0), "grain 0 has the deviation -1, negative"),
        (np.diag(np.append(np.ones(599), -1.0)), "loads: variance 599 is -1, negative"),
    ],
)
def test_odd_errors_of_loads_are_refused(told, message):
    p, part, _, _ = region()
    for method in METHODS:
        with pytest.raises(ValueError, match=message):
            solved(part, p, method, loads=told)


def test_error_maps_have_no_noise_of_loads():
    p, part, f, _ = region()
    with pytest.raises(ValueError, match="errors are per noise of the geometry"):
        error_map(part, "optimal", "position", forces=f, stiffness=p.stiffness, loads=1e-3)
    assert load_errors(force_equation(part), None).shape[1] == 0


def with_wall_force(method, factor, **more):
    """Forces of a packing between walls, one of which was weighed and is told `factor` times that
    (NaN: not weighed), and the packing."""
    p = packing_in("frictional")
    n = ContactNetwork.from_packing(p)
    noisy = perturb(n, XI, np.random.default_rng(3), "position")
    walls = Walls(n.walls.normals, n.walls.offsets, factor * n.walls.loads)
    held = ContactNetwork(
        noisy.positions, noisy.radii, n.pairs, cell=n.cell, images=n.images, walls=walls
    )
    if "loads" in more:
        more["loads"] *= np.nanmax(n.walls.loads)
    if method == "bounded":
        more["pressure"] = "unknown"
    return solved(held, p, method, **more).forces, p


@pytest.mark.parametrize("method", METHODS)
def test_a_wall_that_was_weighed_wrong_is_mended_where_its_error_is_told(method):
    """Told as exact, the control, a force that is a fifth off spoils all others."""
    (right, p), (wrong, _) = (with_wall_force(method, factor) for factor in (1.0, 1.2))
    told, _ = with_wall_force(method, 1.2, loads=0.2)
    least, spoilt, mended = (relative_error(f, p.forces) for f in (right, wrong, told))
    assert mended < 1.2 * least
    assert spoilt > 3 * least
    strong, _ = with_wall_force(method, 1.0, loads=1e-7)
    assert strong == pytest.approx(right, abs=1e-6 * np.abs(right).max())


def test_a_wall_force_with_an_infinite_error_is_not_told():
    """`optimal` then has what it has of a wall that nobody weighed."""
    nothing, _ = with_wall_force("optimal", np.nan)
    weak, _ = with_wall_force("optimal", 1.0, loads=1e6)
    exact, _ = with_wall_force("optimal", 1.0)
    size = np.abs(nothing).max()
    assert weak == pytest.approx(nothing, abs=1e-6 * size)
    assert np.abs(exact - nothing).max() > 1e-3 * size
