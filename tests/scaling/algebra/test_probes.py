"""Squares of rows from random probes: unbiased, with honest bars, whatever the colours."""

from __future__ import annotations

import numpy as np
import pytest

from scaling.algebra.estimate import Estimate
from scaling.algebra.probes import EXACT_UP_TO, Probing, Squares, coloured, probed, probing

SIDE = 12


def decaying(rows: int = 150) -> tuple[np.ndarray, np.ndarray]:
    """Sources on a grid; each row is near one place, and falls off as 1/(1 + distance)²."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    places = np.column_stack([x.ravel(), y.ravel()]).astype(float)
    rng = np.random.default_rng(0)
    centres = rng.uniform(0, SIDE - 1, (rows, 2))
    far = np.linalg.norm(centres[:, None] - places[None], axis=2)
    return rng.choice([-1.0, 1.0], far.shape) / (1 + far) ** 2, places


def totals(probes: int, seeds: int, correlated: bool = False) -> np.ndarray:
    """(Estimate less exact)/bar of Σ |E_e|² for each seed; `correlated` signs are all equal."""
    E, places = decaying()
    exact, off = float((E**2).sum()), []
    for seed in range(seeds):
        if correlated:  # the same probe again and again has no scatter of its own
            z = np.random.default_rng(seed).choice([-1.0, 1.0], E.shape[1])
            sums = ((E @ z) ** 2).sum() * np.ones(probes) + 1e-9 * np.arange(probes)
            found, bar = sums.mean(), sums.std(ddof=1) / np.sqrt(probes)
        else:
            total = probed(lambda z: E @ z, places, len(E), probes, seed).total
            found, bar = float(total), total.error
        off.append((found - exact) / bar)
    return np.array(off)


@pytest.mark.parametrize("probes", [32, 128])
def test_bars_of_probes_are_those_of_their_errors(probes):
    """Over 40 seeds errors have the size of the bars, and no bias.  Control: bars of probes with
    one set of signs are nothing like them."""
    off = totals(probes, 40)
    assert 0.6 < np.sqrt(np.mean(off**2)) < 1.7
    assert abs(off.mean()) < 0.6
    assert np.sqrt(np.mean(totals(probes, 40, correlated=True) ** 2)) > 100


def test_rows_come_with_bars_of_their_own():
    """Of every row, averaged over seeds.  Control: means over rows divided once too often."""
    E, places = decaying()
    exact = (E**2).sum(axis=1)
    runs = [probed(lambda z: E @ z, places, len(E), 128, seed).rows for seed in range(40)]
    off = np.array([(r.values - exact) / np.where(r.error > 0, r.error, np.inf) for r in runs])
    assert 0.5 < np.median(np.abs(off)) < 1.2  # two repeats a colour: bars of few scatter widely
    mean = np.mean([r.values for r in runs], axis=0)
    np.testing.assert_allclose(mean, exact, rtol=0.15)
    assert abs(mean / 2 / exact - 1).min() > 0.3


def test_colours_make_rows_better_than_signs_alone():
    """Sources that are far apart share a colour; numbered at random they do not."""
    E, places = decaying()
    exact = (E**2).sum(axis=1)
    shuffled = np.random.default_rng(5).permutation(places)

    def error(where: np.ndarray) -> float:
        found = [probed(lambda z: E @ z, where, len(E), 128, seed).rows for seed in range(10)]
        return float(np.sqrt(np.mean([(r.values / exact - 1) ** 2 for r in found])))

    assert error(places) < 0.7 * error(shuffled)


def test_points_of_one_colour_are_apart():
    _, places = decaying()
    colour = coloured(places, 3)
    for c in np.unique(colour):
        mine = places[colour == c]
        far = np.linalg.norm(mine[:, None] - mine[None], axis=2) + 1e9 * np.eye(len(mine))
        assert far.min() >= 2.0
    assert len(np.unique(colour)) == 9
    assert coloured(7, 2).tolist() == [0, 1, 2, 3, 0, 1, 2]


def test_one_seed_gives_one_number():
    E, places = decaying()
    a, b, c = (probed(lambda z: E @ z, places, len(E), 32, s).rows.values for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, c)


def test_few_columns_are_taken_exactly_and_said_so():
    assert probing(None).count(EXACT_UP_TO) == 0
    assert probing(None).count(EXACT_UP_TO + 1) == 128
    assert probing(0).count(10**6) == 0
    assert probing(Probing(16, seed=3)).seed == 3
    exact = Squares.exact(np.array([4.0, 12.0])).root_mean()
    assert (float(exact), exact.error, exact.exact) == (np.sqrt(8.0), 0.0, True)


def test_numbers_of_probes_that_are_none():
    with pytest.raises(ValueError, match="probes = 1 has no error bar"):
        probing(1)
    with pytest.raises(ValueError, match="probes"):
        probing(-2)
    with pytest.raises(ValueError, match="probes"):
        probing(2.5)  # type: ignore[arg-type]


def test_an_estimate_is_a_number_with_a_bar():
    four = Estimate(4.0, 0.4, 16)
    assert four + 1 == 5.0
    assert (four.root(), four.root().error) == (2.0, 0.1)
    assert four.scaled(-2.0).error == 0.8
    assert repr(Estimate(2.0)) == "2.0"
    assert "error=0.4" in repr(four)
