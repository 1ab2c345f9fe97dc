"""Lengths in 32 digits: overlaps and loop sums that lose none to cancellation.

    δ_e = R_i + R_j - |x_j - x_i + image shift| ,       Q|σ⟩ - Λ ,   Q made of n_e = d_e/|d_e|

Both are O(Δ) differences of O(1) numbers.  In plain doubles their relative error is ε L/Δ; here
every length is high + low (`doubledouble`), directions included, because Q|σ⟩ needs them to the
precision that it needs sizes to.  No distance enters Q|σ⟩: it stays GPPSZ's equation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, Integers, real_array
from packing.arguments.immutable import Immutable, read_only
from packing.doubledouble import DoubleDouble, hypot, segment_sums
from scaling.geometry.topology.loops import Loops


@dataclass(frozen=True, eq=False)
class LowParts:
    """What doubles leave out of positions, radii and cell: value = high + low.

    Parameters
    ----------
    positions : (N, 2) array, optional
        Of the centres. None: nothing is left out, here and below.
    radii : (N,) array, optional
        Of the radii.
    cell : (2, 2) array, optional
        Of the lattice vectors.

    Examples
    --------
    >>> from scaling.geometry.high_precision import LowParts
    >>> bool(LowParts()), bool(LowParts(radii=[1e-20, 0.0]))
    (False, True)
    """

    positions: ArrayLike | None = None
    radii: ArrayLike | None = None
    cell: ArrayLike | None = None

    def __bool__(self) -> bool:
        """Whether there is any."""
        return not (self.positions is None and self.radii is None and self.cell is None)


NO_LOW_PARTS = LowParts()


@dataclass(frozen=True, eq=False)
class Extended(Immutable):
    """Positions ``x (N, 2)``, ``radii (N,)`` and ``cell (2, 2)`` (None if open) in 32 digits."""

    x: DoubleDouble
    radii: DoubleDouble
    cell: DoubleDouble | None

    @property
    def low(self) -> LowParts:
        """What the doubles leave out."""
        cell = None if self.cell is None else self.cell.low
        return LowParts(self.x.low, self.radii.low, cell)

    def unwrapped(self, shift: Integers) -> Extended:
        """Each grain moved by its ``shift (N, 2)`` of lattice vectors, without the cell."""
        return replace(self, x=self.x + self._lattice(shift), cell=None)

    def tiled(self, place: Integers, n: int) -> Extended:
        """A copy at each `place` (copies, 2), one after the other, in a cell n times as large."""
        assert self.cell is not None
        grain = np.tile(np.arange(len(self.radii.high)), len(place))
        shift = self._lattice(np.repeat(place, len(self.radii.high), axis=0))
        return Extended(self.x[grain] + shift, self.radii[grain], self.cell * float(n))

    def overlaps(self, pairs: Integers, images: Integers) -> Floats:
        """(c,) δ, to 16 digits of itself."""
        _, r = self._branches(pairs, images)
        i, j = pairs.T
        return (self.radii[i] + self.radii[j] - r).high

    def loop_sums(self, pairs: Integers, images: Integers, loops: Loops) -> Floats:
        """(2 l,) Q|σ⟩ - Λ, x rows before y rows, to 16 digits of itself."""
        d, r = self._branches(pairs, images)
        i, j = pairs.T
        σ = self.radii[i] + self.radii[j]
        incidence, signs = loops.incidence, loops.incidence.data.astype(float)
        sums = []
        for k in (0, 1):
            walked = (d[:, k] / r * σ)[incidence.indices] * signs
            total = segment_sums(walked, incidence.indptr.astype(np.int64))
            if self.cell is not None:
                total = total - self._lattice(loops.images)[:, k]
            sums.append(total.high)
        return np.concatenate(sums)

    def _branches(self, pairs: Integers, images: Integers) -> tuple[DoubleDouble, DoubleDouble]:
        i, j = pairs.T
        d = self.x[j] - self.x[i]
        if self.cell is not None:
            d = d + self._lattice(images)
        return d, hypot(d[:, 0], d[:, 1])

    def _lattice(self, images: Integers) -> DoubleDouble:
        assert self.cell is not None
        a, b = (np.repeat(images[:, k, None].astype(float), 2, axis=1) for k in (0, 1))
        return self.cell[0] * a + self.cell[1] * b


def with_low_parts(
    positions: Floats | None, radii: Floats, cell: Floats | None, low: LowParts
) -> Extended | None:
    """None without low parts.  ValueError: a low part without its high, or not small beside it."""
    if not low:
        return None
    if positions is None:
        raise ValueError("low parts are given, but no positions: overlaps would not have them")
    if cell is None and low.cell is not None:
        raise ValueError("low.cell is given, but there is no cell")
    return Extended(
        _joined("low.positions", positions, low.positions, positions, radii),
        _joined("low.radii", radii, low.radii, radii),
        None if cell is None else _joined("low.cell", cell, low.cell, cell),
    )


def _joined(name: str, high: Floats, low: ArrayLike | None, *lengths: Floats) -> DoubleDouble:
    """high + low, `low` below the rounding of the largest of `lengths`, in any unit."""
    if low is None:
        return _frozen(DoubleDouble.of(high))
    part = real_array(name, low, np.shape(high))
    # A rounded coordinate leaves half an ulp of the largest out; anything else is a mix-up.
    allowed = 4 * np.finfo(float).eps * max(float(np.abs(each).max()) for each in lengths)
    if np.abs(part).max(initial=0.0) > allowed:
        raise ValueError(
            f"{name} reaches {np.abs(part).max():.3g}: a low part is below one ulp, {allowed:.1g}"
        )
    return _frozen(DoubleDouble.of(high, part))


def _frozen(number: DoubleDouble) -> DoubleDouble:
    read_only((number.high, number.low))
    return number
