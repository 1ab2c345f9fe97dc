"""Rounded coordinates: recognised, reported, and noise like any other."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import rounding
from scaling import CoarseCoordinatesWarning, ContactNetwork
from scaling.resolution import resolution, rounding_noise
from tests.conftest import packing

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
