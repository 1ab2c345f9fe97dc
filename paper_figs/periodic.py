"""What of a periodic packing lies in a square window: every copy of its grains and contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import Circle


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
    centre: Sequence[float]
    width: float

    def copies(self, points: np.ndarray, margin: float) -> tuple[np.ndarray, np.ndarray]:
        """Indices ``(m,)`` and places ``(m, 2)`` of all copies within ``margin`` of the window."""
        sides = self.cell.sides
        low = np.asarray(self.centre) - self.width / 2
        base = points - np.floor((points - low) / sides) * sides
        found = [base + np.array(shift) * sides for shift in product((-1, 0, 1), repeat=2)]
        places = np.concatenate(found)
        inside = np.all((places > low - margin) & (places < low + self.width + margin), axis=1)
        return np.tile(np.arange(len(points)), len(found))[inside], places[inside]

    def grains(self, axes: Axes, colours: np.ndarray | None = None, **style: object) -> None:
        """Draw the grains, coloured by one number each if ``colours`` are given."""
        radii = self.cell.radii
        index, places = self.copies(self.cell.positions, float(radii.max()))
        discs = [Circle(x, radii[k]) for k, x in zip(index, places, strict=True)]
        if colours is not None:
            style["array"] = colours[index]
        axes.add_collection(PatchCollection(discs, linewidth=0.3, **style))

    def contacts(
        self, axes: Axes, starts: np.ndarray, ends: np.ndarray, **style: object
    ) -> LineCollection:
        """Draw contacts as lines; arrays in ``style`` hold one value a contact."""
        branch = ends - starts
        index, places = self.copies(starts, float(np.abs(branch).max()))
        mine = {k: v[index] if isinstance(v, np.ndarray) else v for k, v in style.items()}
        segments = np.stack([places, places + branch[index]], axis=1)
        lines = LineCollection(segments, capstyle="round", **mine)
        axes.add_collection(lines)
        return lines

    def frame(self, axes: Axes) -> None:
        """Limits, equal scales, no ticks."""
        half = self.width / 2
        axes.set(aspect="equal", xticks=[], yticks=[])
        axes.set_xlim(self.centre[0] - half, self.centre[0] + half)
        axes.set_ylim(self.centre[1] - half, self.centre[1] + half)
