"""Dumps as LAMMPS writes them, of packings of our own; columns named as by its computes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packing.record import Packing


@dataclass(frozen=True)
class Dump:
    """How the dumps are written.

    ``number`` the format of numbers; ``coordinates`` x, xu, xs or xsu; ``order`` of the columns of
    contacts; ``second`` forces on the second grain; ``reverse`` names each contact (j, i);
    ``whole`` the whole force in place of its two parts; ``viscous`` dashpot times the velocities,
    which are then in the dump.
    """

    number: str = "%.17g"
    coordinates: str = "x"
    order: tuple[int, ...] = tuple(range(8))
    second: bool = False
    reverse: bool = False
    frames: int = 1
    viscous: float = 0.0
    whole: bool = False

    def write(self, folder: Path, p: Packing) -> tuple[Path, Path]:
        """NAME.atoms and NAME.contacts."""
        atoms, contacts = folder / "a.atoms.dump", folder / "a.contacts.dump"
        early = "".join(self._atoms(p, step, 1.5) for step in range(self.frames - 1))
        atoms.write_text(early + self._atoms(p, self.frames - 1, 1.0))
        early = "".join(self._contacts(p, step, 1.5) for step in range(self.frames - 1))
        contacts.write_text(early + self._contacts(p, self.frames - 1, 1.0))
        return atoms, contacts

    def _row(self, values: object) -> str:
        return " ".join(
            str(v) if isinstance(v, int) else self.number % v
            for v in values  # type: ignore[attr-defined]
        )

    def _head(self, p: Packing, step: int, count: int, of: str) -> str:
        assert p.cell is not None
        (a, _), (xy, b) = p.cell.tolist()
        low, high = min(0.0, xy), a + max(0.0, xy)
        tilt = f"{low!r} {high!r} {xy!r}\n0 {b!r} 0\n-0.5 0.5 0\n"
        box = f"ITEM: BOX BOUNDS xy xz yz pp pp pp\n{tilt}"
        if xy == 0:
            box = f"ITEM: BOX BOUNDS pp pp pp\n0 {a!r}\n0 {b!r}\n-0.5 0.5\n"
        return f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF {of}\n{count}\n{box}"

    def _atoms(self, p: Packing, step: int, stretch: float) -> str:
        x, suffix = p.positions * stretch, self.coordinates[1:]
        fractions = x @ np.linalg.inv(p.cell)
        if self.coordinates in ("x", "xs"):
            fractions = fractions - np.floor(fractions)
        values = fractions if "s" in suffix else fractions @ p.cell
        if self.coordinates == "xu":
            values = x
        order = np.random.default_rng(1).permutation(len(x))
        v = velocities(p) if self.viscous else np.zeros((len(x), 0))
        rows = [
            self._row([*values[k].tolist(), int(k) + 1, float(2 * p.radii[k]), *v[k].tolist()])
            for k in order
        ]
        head = self._head(p, step, len(x), "ATOMS")
        names = f"ITEM: ATOMS x{suffix} y{suffix} id diameter" + " vx vy" * bool(self.viscous)
        return head + "\n".join([names, *rows]) + "\n"

    def _contacts(self, p: Packing, step: int, stretch: float) -> str:
        d = p.branches
        n = np.column_stack([d.real, d.imag]) / np.abs(d)[:, None]
        t = np.column_stack([-n[:, 1], n[:, 0]])
        v = velocities(p)[p.pairs[:, 0]] - velocities(p)[p.pairs[:, 1]]
        f_n = p.normal_forces + self.viscous * np.sum(v * n, axis=1)
        along, across = -f_n[:, None] * n, p.tangential_forces[:, None] * t
        if self.whole:
            along, across = along + across, np.zeros_like(across)
        sign = (-1.0 if self.second else 1.0) * (-1.0 if self.reverse else 1.0)
        rows = []
        for e, (i, j) in enumerate(p.pairs.tolist()):
            first, other = (j, i) if self.reverse else (i, j)
            values = [
                first + 1,
                other + 1,
                float(abs(d[e])),
                float(f_n[e]),
                *(sign * along[e] * stretch).tolist(),
                *(sign * across[e] * stretch).tolist(),
            ]
            rows.append(self._row([values[k] for k in self.order]))
        names = [f"c_pd[{k + 1}]" for k in self.order]
        head = self._head(p, step, len(rows), "ENTRIES")
        return head + "\n".join([f"ITEM: ENTRIES {' '.join(names)}", *rows]) + "\n"


def velocities(p: Packing) -> np.ndarray:
    """Of order one, (N, 2)."""
    return np.random.default_rng(2).normal(size=(len(p.radii), 2))
