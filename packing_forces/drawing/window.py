"""What of a periodic packing lies in a square window: every copy of its grains and contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import Circle

from packing_forces.drawing.copies import copies_within


@dataclass(frozen=True)
class Cell:
    """The grains ``(N, 2)``, ``(N,)`` of a rectangular periodic cell with ``sides`` ``(2,)``."""

    positions: np.ndarray
    radii: np.ndarray
    sides: np.ndarray

    @classmethod
    def of(cls, grains: np.ndarray) -> Cell:
        """From the table ``grains``, in which the sides repeat."""
        sides = np.array([grains["width"][0], grains["height"][0]])
        return cls(np.column_stack([grains["x"], grains["y"]]), grains["radius"], sides)


@dataclass(frozen=True)
class Window:
    """A square of side ``width`` about ``centre``, both in ⟨σ⟩, no wider than the cell."""

    cell: Cell
    centre: Sequence[float] | np.ndarray
    width: float

    def copies(self, points: np.ndarray, margin: float) -> tuple[np.ndarray, np.ndarray]:
        """Indices ``(m,)`` and places ``(m, 2)`` of all copies within ``margin`` of the window."""
        low = np.asarray(self.centre) - self.width / 2
        lattice = np.diag(self.cell.sides)
        return copies_within(points, lattice, low - margin, low + self.width + margin)

    def grains(self, axes: Axes, colours: np.ndarray | None = None, **style: Any) -> None:
        """Draw the grains, coloured by one number each if ``colours`` are given."""
        radii = self.cell.radii
        index, places = self.copies(self.cell.positions, float(radii.max()))
        if colours is not None:
            style["array"] = colours[index]
        axes.add_collection(discs(places, radii[index], **style))

    def contacts(
        self, axes: Axes, starts: np.ndarray, ends: np.ndarray, **style: Any
    ) -> LineCollection:
        """Draw contacts as lines; arrays in ``style`` hold one value a contact."""
        branch = ends - starts
        index, places = self.copies(starts, float(np.abs(branch).max()))
        mine = {k: v[index] if isinstance(v, np.ndarray) else v for k, v in style.items()}
        lines = segments(places, branch[index], **mine)
        axes.add_collection(lines)
        return lines

    def frame(self, axes: Axes) -> None:
        """Limits, equal scales, no ticks."""
        half = self.width / 2
        axes.set(aspect="equal", xticks=[], yticks=[])
        axes.set_xlim(self.centre[0] - half, self.centre[0] + half)
        axes.set_ylim(self.centre[1] - half, self.centre[1] + half)


def discs(places: np.ndarray, radii: np.ndarray, **style: Any) -> PatchCollection:
    """Grains as circles."""
    circles = [Circle((x[0], x[1]), R) for x, R in zip(places, radii, strict=True)]
    return PatchCollection(circles, linewidth=0.3, **style)


def segments(places: np.ndarray, branches: np.ndarray, **style: Any) -> LineCollection:
    """Contacts as lines from ``places`` along ``branches``, both (c, 2)."""
    ends = np.stack([places, places + branches], axis=1)
    return LineCollection(list(ends), capstyle="round", **style)
