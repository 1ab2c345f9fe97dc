"""Rounded coordinates: recognised, reported, and noise like any other."""

from __future__ import annotations

import pickle
import re
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from packing.arguments.coordinate_rounding import resolution, rounding_noise
from scaling import (
    CoarseCoordinatesWarning,
    ContactNetwork,
    perturb,
    reconstruct,
    relative_error,
    rescaled,
    rounded,
    tiled,
)
from studies.experiment import rounding
from tests.conftest import packing
from tests.scaling.networks import lattice, rhombus, ring, triangle

KINDS = ("float16", "float32", "2 decimals", "5 decimals", "9 decimals")


@pytest.mark.parametrize("kind", KINDS)
def test_grid_is_recognised_from_the_numbers(kind):
    x = rounding.rounded(np.random.default_rng(0).uniform(0, 30, 200), kind)
    assert resolution(x).kind == kind
    assert resolution(np.r_[x, 1 / 3]).kind == "float64"


@pytest.mark.parametrize("kind", KINDS)
def test_rounding_noise_is_the_rms_of_what_rounding_does(kind):
    """Uniform in ±h/2: h/√12, within 5 standard errors of the mean square (kurtosis 9/5)."""
    x = np.random.default_rng(0).uniform(0, 30, 20_000)
    lost = rounding.rounded(x, kind) - x
    assert np.mean(lost**2) == pytest.approx(rounding_noise(x, kind) ** 2, rel=0.05)


def test_few_numbers_are_no_evidence():
    assert resolution([0.0, 0.5, 1.0]).kind == "float64"
    assert resolution(np.repeat([0.4, 0.6], 50)).kind == "float64"


def test_rounding_falls_on_the_collapse():
    """E over the prediction for noise h/√12 within a factor 2 (one draw each of 2c errors), over
    seven decades of resolution and five of Δ.  The control: errors of one resolution alone, say 5
    decimals, spread over more than 1e4, and the factor √12 is seen."""
    packings = [packing(grains=64, delta=d) for d in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)]
    table = rounding.compute(packings)
    off = table["error"] / table["predicted"]
    assert 0.5 < off.min() < off.max() < 2
    assert np.median(off) == pytest.approx(1, abs=0.1)
    five = table[table["kind"] == "5 decimals"]
    assert five["error"].max() / five["error"].min() > 1e4
    assert np.median(off) * np.sqrt(12) > 3
    assert {"float16", "float32"} <= set(table["kind"])


def rounded_packing(kind: str, delta: float) -> SimpleNamespace:
    p = packing(grains=64, delta=delta)
    names = ("radii", "pairs", "images", "cell", "external")
    fields = {name: getattr(p, name) for name in names}
    return SimpleNamespace(**fields, positions=rounding.rounded(p.positions, kind))


@pytest.mark.parametrize(
    ("kind", "delta", "warns"),
    [
        ("float32", 1e-6, True),
        ("float32", 1e-3, False),
        ("5 decimals", 1e-4, True),
        ("5 decimals", 1e-2, False),
        ("9 decimals", 1e-6, False),
        ("float16", 1e-2, True),
    ],
)
def test_from_packing_warns_when_rounding_is_not_far_below_the_overlaps(kind, delta, warns):
    rounded = rounded_packing(kind, delta)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ContactNetwork.from_packing(rounded)
    found = [w for w in caught if issubclass(w.category, CoarseCoordinatesWarning)]
    assert bool(found) == warns
    if warns:
        assert kind in str(found[0].message)
        assert found[0].filename == __file__


def test_doubles_are_too_coarse_at_tiny_deformations_and_low_parts_are_not():
    p = packing(delta=1e-12)
    plain = SimpleNamespace(
        positions=p.positions, radii=p.radii, pairs=p.pairs, images=p.images, cell=p.cell
    )
    far = packing(delta=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ContactNetwork.from_packing(p)
        ContactNetwork.from_packing(far)
    scaled = SimpleNamespace(**vars(plain) | {"positions": p.positions + 1000.0})
    with pytest.warns(CoarseCoordinatesWarning, match="float64"):
        ContactNetwork.from_packing(scaled)


# --- significant digits, and every constructor --------------------------------------------


def printed(values, how="%g"):
    return np.vectorize(lambda v: float(how % v))(values)


@pytest.mark.parametrize(
    ("how", "kind"),
    [("%g", "6 digits"), ("%.3e", "4 digits"), ("%.9e", "10 digits"), ("%.4f", "4 decimals")],
)
@pytest.mark.parametrize("size", [1e-7, 1.0, 1e5])
def test_significant_digits_are_recognised_in_any_unit(how, kind, size):
    """Six digits of numbers from 0.3 to 30 are four to six decimals: noise of the coarsest."""
    if how.endswith("f") and size != 1:
        return
    x = size * 10 ** np.random.default_rng(0).uniform(-0.5, 1.5, 500)
    seen = resolution(printed(x, how))
    assert seen.kind == kind
    lost = printed(x, how) - x
    assert np.sqrt(np.mean(lost**2)) == pytest.approx(seen.noise, rel=0.2)
    assert resolution(np.r_[printed(x, how), size / 3]).kind == "float64"


def said(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = call()
    found = [w for w in caught if issubclass(w.category, CoarseCoordinatesWarning)]
    assert all(w.filename == __file__ for w in found)
    return made, [str(w.message) for w in found]


def arguments(p, how, *names):
    """The fields of a packing, those of `names` printed."""
    fields = {k: getattr(p, k) for k in ("positions", "radii", "pairs", "cell", "images")}
    sides = np.diag(p.cell)
    jump = -np.floor(p.positions / sides).astype(int)  # into the cell, as a file has them
    i, j = p.pairs.T
    fields |= {"positions": p.positions + jump * sides, "images": p.images + jump[i] - jump[j]}
    return fields | {name: printed(fields[name], how) for name in names}


@pytest.mark.parametrize("names", [("positions",), ("radii",), ("cell",), ("positions", "radii")])
def test_every_constructor_warns_of_what_was_rounded(names):
    """%g dumps at Δ = 1e-5, by the class and from a record: said once, at the line of the user.
    The control: all digits, and six digits at Δ = 0.01."""
    p = packing(grains=64, delta=1e-5)
    fields = arguments(p, "%g", *names)
    for make in (
        lambda: ContactNetwork(**fields),
        lambda: ContactNetwork.from_packing(SimpleNamespace(**fields)),
    ):
        _, messages = said(make)
        assert len(messages) == 1
        assert all(name in messages[0] for name in names)
        assert "digits" in messages[0] or "decimals" in messages[0]
    assert said(lambda: ContactNetwork(**arguments(p, "%.17g", *names)))[1] == []
    soft = packing(grains=64, delta=1e-2)
    assert said(lambda: ContactNetwork(**arguments(soft, "%g", *names)))[1] == []


def test_the_expected_error_is_stated():
    """E ≈ 0.7 ξ/⟨δ⟩, over six packings within a factor two of what rounding does, each within
    three."""
    off = []
    for seed in range(6):
        p = packing(grains=64, delta=1e-4, seed=seed)
        n, (message,) = said(
            lambda p=p: ContactNetwork(**arguments(p, "%g", "positions", "radii"))
        )
        stated = float(re.search(r"= (\S+) of the mean force", message).group(1))
        off.append(relative_error(reconstruct(n, 1.0), p) / stated)
    assert min(off) > 1 / 3
    assert max(off) < 3
    assert 0.5 < np.median(off) < 2


def test_what_is_made_from_a_network_does_not_warn_again():
    """Noise, scales, cuts, tiles and estimates of a network that was warned of: not a word."""
    p = packing(grains=64, delta=1e-4)
    n, messages = said(lambda: ContactNetwork(**arguments(p, "%g", "positions", "radii")))
    assert messages
    f = p.forces.reshape(2, -1)
    rng = np.random.default_rng(0)
    for make in (
        lambda: perturb(n, 1e-4, rng, "position"),
        lambda: perturb(n, 1e-4, rng),
        lambda: rescaled(n, 1e-6, 1e-6),
        lambda: rounded(n, 3),
        lambda: tiled(n, 2),
        lambda: n.inside(np.arange(30), *f),
        lambda: n.without_rattlers(),
        lambda: n.with_sizes(n.radii),
        lambda: reconstruct(n, 1.0, "optimal", xi=1e-3, noise="position"),
        lambda: pickle.loads(pickle.dumps(n)),
    ):
        assert said(make)[1] == []


@pytest.mark.parametrize(
    "network",
    [
        lambda: triangle(1.0, 0.51),
        lambda: rhombus(0.502),
        lambda: ring(7, 0.501),
        lambda: lattice("square", 6),
        lambda: lattice("triangular", 6),
    ],
)
def test_small_networks_typed_by_hand_and_lattices_are_silent(network):
    """Fewer than 16 different numbers are no evidence; integers of a lattice were not rounded, as
    its overlaps show, which rounding would have scattered. Touching grains have no deformation."""
    assert said(network)[1] == []
    side = np.arange(5)
    x = 0.98 * np.array([[a, b] for a in side for b in np.arange(20)])  # 20 different numbers
    pairs = [(k, k + 1) for k in range(99) if k % 20 < 19] + [(k, k + 20) for k in range(80)]
    assert said(lambda: ContactNetwork(x, np.full(100, 0.5), pairs))[1] == []
    moved = np.round(x + np.random.default_rng(0).uniform(-0.004, 0.004, x.shape), 3)
    assert len(said(lambda: ContactNetwork(moved, np.full(100, 0.5), pairs))[1]) == 1


def test_sixteen_different_numbers_are_evidence():
    """A row of grains with coordinates of three decimals: silent with 15 of them, not with 16."""
    rng = np.random.default_rng(0)
    for count, warned in ((15, False), (16, True)):
        x = np.round(np.arange(1, count + 1) * 0.99 + rng.uniform(-0.004, 0.004, count), 3)
        pairs = [(k, k + 1) for k in range(count - 1)]
        at = np.column_stack([x, np.full(count, x[0])])
        assert len(np.unique(at)) == count
        assert bool(said(lambda at=at, pairs=pairs, count=count: ContactNetwork(
            at, np.full(count, 0.5), pairs))[1]) == warned  # fmt: skip


def test_directions_measured_need_no_overlaps():
    p = packing(grains=64, delta=1e-4)
    n = ContactNetwork.from_packing(p)
    fields = arguments(p, "%.3f", "positions")
    assert said(lambda: ContactNetwork(**fields, normals=n.normals))[1] == []


@pytest.mark.parametrize(
    "kind", ["float", "float99", "decimals", "digits", "", None, 3, "x digits"]
)
def test_unknown_kinds_are_refused(kind):
    with pytest.raises(ValueError, match=r"kind = .* is unknown"):
        rounding_noise([0.5], kind)
