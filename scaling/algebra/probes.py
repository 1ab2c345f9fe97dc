"""Squares of the rows of a matrix E (n, k) that is known by its products only, by random probes.

With z = ±1 the mean of (E z)_e² is |E_e|², with the relative error √2 a probe: 1/√(2 P) of |E_e|
after P probes, whatever E.  Where source j acts near a place, errors fall with distance, and so
probes are *coloured*: sources far apart share a colour, each colour has signs of its own, and
sums over colours replace means over probes (Tang and Saad 2012; Stathopoulos, Laeuchli and
Orginos 2013).  What is left are products of sources of one colour: near one row at most one of
them is strong.  Every colour is repeated twice or more, and the scatter of its repeats, added up
over colours, is the error bar.

Standard errors of the root of Σ_e |E_e|² (K) and of a row (median, largest), of N = 1000 grains:

                        P = 2           32              128             random, 128
    gppsz       K       1.2 %           0.17 %          0.06 %          0.15 %
                rows    43 (48) %       4 (16) %        0.7 (2) %       6 %
    balanced    K       2.3 %           0.38 %          0.15 %          0.28 %
                rows    48 (49) %       9 (15) %        2.8 (6) %       6 %
    optimal     K       3.7 %           0.77 %          0.33 %          0.46 %
                rows    48 (50) %       10 (18) %       3.5 (9) %       6 %

Of K it falls as 1/√N besides; of rows it does not depend on N.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.numbers import seed_number, whole_number
from scaling.algebra.elimination import COLUMNS
from scaling.algebra.estimate import Estimate, Estimates

EXACT_UP_TO = 2048
"""Columns up to which all of them are solved for: about a second."""
PROBES = 128
"""Probes for more columns than that: 64 colours, twice."""


@dataclass(frozen=True)
class Probing:
    """How many probes to take, and the seed of their signs.

    Parameters
    ----------
    probes : int, optional
        0 for an exact result, 2 or more for so many probes; None: exact up to 2048 sources of
        noise, which takes about a second, 128 probes beyond
    seed : int
        Of the signs: the same seed gives the same numbers

    Raises
    ------
    ValueError
        One probe, which has no error bar, or a number that is none.

    Notes
    -----
    The curve of accuracy against probes stands in `scaling.algebra.probes`.

    Examples
    --------
    >>> Probing().count(2000), Probing().count(100_000), Probing(0).count(100_000)
    (0, 128, 0)
    """

    probes: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if self.probes is not None and whole_number("probes", self.probes, 0) == 1:
            raise ValueError("probes = 1 has no error bar: take 0 for an exact result, or >= 2")
        seed_number(self.seed)

    def count(self, sources: int) -> int:
        """Probes for so many sources; 0 is exact."""
        if self.probes is None:
            return 0 if sources <= EXACT_UP_TO else PROBES
        return int(self.probes)


def probing(probes: int | Probing | None) -> Probing:
    """A number of probes, or a record of it and of a seed, as that record."""
    return probes if isinstance(probes, Probing) else Probing(probes)


@dataclass(frozen=True, eq=False)
class Squares:
    """|E_e|² of every row, and their sum, whose bar is not that of independent rows."""

    rows: Estimates
    total: Estimate

    @classmethod
    def exact(cls, rows: Floats) -> Squares:
        """Of rows (n,) that are known."""
        return cls(Estimates(rows, np.zeros(len(rows)), 0), Estimate(np.sum(rows)))

    def root_mean(self) -> Estimate:
        """Root of the mean over rows."""
        n, total = len(self.rows.values), self.total
        return Estimate(total / n, total.error / n, total.probes).root()


def probed(
    product: Callable[[Floats], Floats],
    places: Floats | int,
    rows: int,
    probes: int,
    seed: int = 0,
) -> Squares:
    """Squares of the rows of E from products E z, z (k, m), for `probes` >= 2 of them.

    `places` (k, 2) of the sources, or their number k: numbered neighbours then count as near.
    """
    side = max(1, int(np.sqrt(probes // 2)))
    colour = coloured(places, side)
    k, colours = len(colour), side * side
    repeats = np.full(colours, probes // colours) + (np.arange(colours) < probes % colours)
    mean, variance, total, spread = np.zeros(rows), np.zeros(rows), 0.0, 0.0
    rng, each = np.random.default_rng(seed), max(1, COLUMNS // int(repeats.max()))
    used = np.unique(colour)  # few sources leave colours without any
    for start in range(0, len(used), each):
        some = used[start : start + each]
        of_column = np.repeat(some, repeats[some])
        z = np.where(colour[:, None] == of_column, rng.choice([-1.0, 1.0], (k, len(of_column))), 0)
        y = product(z) ** 2
        for c in some:
            mine = y[:, of_column == c]
            r, sums = mine.shape[1], mine.sum(axis=0)
            mean += mine.mean(axis=1)
            variance += mine.var(axis=1, ddof=1) / r
            total += float(sums.mean())
            spread += float(sums.var(ddof=1)) / r
    return Squares(
        Estimates(mean, np.sqrt(variance), probes), Estimate(total, np.sqrt(spread), probes)
    )


def coloured(places: Floats | int, side: int) -> Integers:
    """(k,) colours, side² of them, such that points of one colour are about `side` apart.

    Points are put into strips and numbered along each; strips and numbers count modulo `side`.
    """
    if isinstance(places, int):
        return np.arange(places) % (side * side)
    k, (width, height) = len(places), np.ptp(places, axis=0)
    wanted = np.sqrt(k * width / height) if height > 0 else 1.0
    # Whole numbers of rounds of colours, so that they fit across the sides of a periodic cell.
    strips = int(np.clip(side * round(wanted / side), side, max(k, side)))
    strip = np.empty(k, np.int64)
    strip[np.argsort(places[:, 0], kind="stable")] = np.arange(k) * strips // max(k, 1)
    order = np.lexsort((places[:, 1], strip))
    first = np.searchsorted(strip[order], np.arange(strips + 1))
    length = np.diff(first)[strip[order]]
    step = np.arange(k) - first[strip[order]]
    along = np.empty(k, np.int64)
    along[order] = step * (side * -(-length // side)) // length
    return (strip % side) * side + along % side
