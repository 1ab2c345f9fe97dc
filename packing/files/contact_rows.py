"""Contacts as files list them, brought into the order of this project.

A file may name the grains of a contact in either order, list it twice, list neighbours that bear
no force.  Named the other way round, a contact has n and t turned round and its images negated;
f_n and f_t stay what they are:

    force on i   -f_n n + f_t t   =   -( -f_n n' + f_t t' )   with n' = -n, t' = -t .
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.contacts.contact_list import seen_ahead
from packing.files.problem import FileProblem
from packing.files.text import Text
from packing.note import Note

_SAME = 1e-6
"""Forces of the two listings of one contact agree to so much of the mean force."""


@dataclass(frozen=True, eq=False)
class ContactRows:
    """Contacts (c,) in the order of their file.

    ``pairs`` (c, 2) places of the grains, N + w for wall w; ``images`` (c, 2); ``normal``,
    ``tangential`` (c,); ``normals`` (c, 2) from the first to the second; ``lines`` (c,) from 1.
    """

    pairs: Integers
    images: Integers
    normal: Floats | None
    tangential: Floats | None
    lines: Integers
    normals: Floats | None = None

    def kept(self, which: np.ndarray) -> ContactRows:
        """Those that a mask or a list of indices picks."""
        return ContactRows(
            self.pairs[which],
            self.images[which],
            None if self.normal is None else self.normal[which],
            None if self.tangential is None else self.tangential[which],
            self.lines[which],
            None if self.normals is None else self.normals[which],
        )

    def turned(self) -> ContactRows:
        """All named with i <= j."""
        back = self.pairs[:, 0] > self.pairs[:, 1]
        images = np.where(back[:, None], -self.images, self.images)
        pairs = np.sort(self.pairs, axis=1)
        normals = self.normals
        if normals is not None:
            normals = np.where(back[:, None], -normals, normals)
        return replace(self, pairs=pairs, images=seen_ahead(pairs, images), normals=normals)


def ordered(rows: ContactRows, grains: int, text: Text) -> tuple[ContactRows, tuple[Note, ...]]:
    """The rows with i <= j, each once, those with walls last; and what was left out.

    FileProblem: a grain with itself, a contact that is
    listed twice with other forces.
    """
    found: list[Note] = []
    itself = (rows.pairs[:, 0] == rows.pairs[:, 1]) & ~rows.images.any(axis=1)
    if itself.any():
        e = int(np.argmax(itself))
        raise text.problem(
            "damaged",
            f"grain {rows.pairs[e, 0]} (counted from 0) touches itself",
            int(rows.lines[e]) - 1,
            float(rows.pairs[e, 0]),
        )
    if rows.normal is not None:
        none = rows.normal == 0
        if rows.tangential is not None:
            none &= rows.tangential == 0
        if none.any():
            found.append(
                text.note(
                    "information",
                    "zero-force",
                    f"{none.sum()} of {len(none)} listed pairs bear no force and are left out",
                    int(rows.lines[np.argmax(none)]) - 1,
                    int(none.sum()),
                )
            )
            rows = rows.kept(~none)
    rows = rows.turned()
    rows, twice = _once(rows, text)
    at_wall = rows.pairs[:, 1] >= grains
    return rows.kept(np.argsort(at_wall, kind="stable")), (*found, *twice)


def _once(rows: ContactRows, text: Text) -> tuple[ContactRows, list[Note]]:
    keys = np.column_stack([rows.pairs, rows.images])
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    original = first[np.reshape(inverse, -1)]
    again = np.flatnonzero(original != np.arange(len(keys)))
    if not len(again):
        return rows, []
    for values in (rows.normal, rows.tangential):
        if values is None:
            continue
        scale = float(np.abs(values).mean())
        differ = np.abs(values[again] - values[original[again]]) > _SAME * scale
        if differ.any():
            e = int(again[np.argmax(differ)])
            raise _differing(rows, e, int(original[e]), values, text)
    e = int(again[0])
    note = text.note(
        "warning",
        "listed-twice",
        f"{len(again)} of {len(keys)} contacts stand twice in the list, "
        f"the first again in line {rows.lines[e]}; each is taken once",
        int(rows.lines[e]) - 1,
        len(again),
    )
    return rows.kept(np.sort(first)), [note]


def _differing(rows: ContactRows, e: int, o: int, values: Floats, text: Text) -> FileProblem:
    i, j = rows.pairs[e].tolist()
    return text.problem(
        "listed-twice",
        f"grains {i} and {j} (counted from 0) touch in lines {rows.lines[o]} and "
        f"{rows.lines[e]} with the forces {values[o]:.6g} and {values[e]:.6g}",
        int(rows.lines[e]) - 1,
        float(values[e]),
    )


def unit_normals(
    branches: Floats, pairs: Integers, text: Text, lines: Sequence[int] | Integers
) -> Floats:
    """(c, 2) n of these branches; FileProblem: two centres at one point, with their line."""
    r = np.hypot(*branches.T)
    if (r == 0).any():
        e = int(np.argmax(r == 0))
        i, j = pairs[e].tolist()
        raise text.problem(
            "damaged",
            f"grains {i} and {j} (counted from 0) touch, and lie at one point",
            int(lines[e]) - 1,
        )
    return np.asarray(branches / r[:, None])


def places(
    numbers: Floats, ids: Integers, text: Text, lines: Sequence[int] | Integers
) -> Integers:
    """Places in the list ``ids`` of grains of the ``numbers`` (c, k) that a file calls them by.

    FileProblem: a number that no grain has, with its line (from 1).
    """
    order = np.argsort(ids, kind="stable")
    at = np.clip(np.searchsorted(ids, numbers, sorter=order), 0, len(ids) - 1)
    found = order[at]
    unknown = ids[found] != numbers
    if unknown.any():
        e, k = np.argwhere(unknown)[0].tolist()
        raise text.problem(
            "unknown-grain",
            f"the contact names grain {numbers[e, k]:.15g}, but the {len(ids)} "
            f"grains are {ids.min()} ... {ids.max()}"
            + ("" if np.ptp(ids) + 1 == len(ids) else " with gaps"),
            int(lines[e]) - 1,
            float(numbers[e, k]),
        )
    return np.asarray(found, dtype=np.int64)


def grain_ids(numbers: Floats, text: Text, lines: Sequence[int] | Integers) -> Integers:
    """Ids (N,) of grains; FileProblem: no whole number, or one twice, with its line (from 1)."""
    odd = (numbers != np.round(numbers)) | (np.abs(numbers) > 2**53)
    if odd.any():
        e = int(np.argmax(odd))
        raise text.problem(
            "no-number",
            f"the number of a grain is {numbers[e]:.6g}, not whole",
            int(lines[e]) - 1,
            float(numbers[e]),
        )
    ids = numbers.astype(np.int64)
    _, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
    again = first[np.reshape(inverse, -1)] != np.arange(len(ids))
    if again.any():
        e = int(np.argmax(again))
        raise text.problem(
            "grain-twice",
            f"grain {ids[e]} is there twice, first in line "
            f"{lines[first[np.reshape(inverse, -1)[e]]]}",
            int(lines[e]) - 1,
            float(ids[e]),
        )
    return ids


def good_radii(radii: Floats, text: Text, lines: Sequence[int] | Integers) -> Floats:
    """``radii``; FileProblem: one that is not positive, with its line (from 1)."""
    if (radii <= 0).any():
        e = int(np.argmax(radii <= 0))
        raise text.problem(
            "bad-radius",
            f"a radius is {radii[e]:.6g}, not positive",
            int(lines[e]) - 1,
            float(radii[e]),
        )
    return radii
