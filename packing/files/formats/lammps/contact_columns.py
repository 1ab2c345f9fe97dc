"""What the columns of a `dump local` mean, read off the data where no one says it.

Columns like c_pd[3] carry no meaning in their names.  The data show it: ids are whole numbers of
grains that lie next to each other; the vector of the normal force is parallel to the line of
centres, that of the tangential force perpendicular to it.  A normal force that points to the
second grain in most contacts acts on the second: the contacts of grains at rest push.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.numbers import shown
from packing.files.contact_rows import places
from packing.files.formats.lammps.frames import Frame
from packing.note import Note

MEANINGS = ("id1", "id2", "normal", "tangential", "force", "fn", "ft")
_SINGLE = ("id1", "id2", "fn", "ft")
"""Meanings of one column; the others are vectors."""
_BALANCED = 0.02
"""Of ⟨|F|⟩, the rms net force on grains up to which a vector is the whole force."""
_PARALLEL = 1e-3
"""Sine of the angle up to which vectors count as parallel, rms over contacts."""
_REACH = 1.5
"""Distance over the sum of radii up to which grains are neighbours."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Places of columns: two ids; two components each of the force vectors that are there."""

    ids: tuple[int, int]
    vectors: dict[str, tuple[int, int]]
    notes: tuple[Note, ...] = ()


def told_columns(frame: Frame, columns: Mapping[str, object]) -> Columns:
    """The places of columns that the user named.

    ``columns``: id1, id2 -> a name; normal, tangential, force -> two names.  ValueError: a
    meaning or column that is not known.
    """
    at: dict[str, tuple[int, ...]] = {}
    for meaning, names in columns.items():
        if meaning not in MEANINGS:
            raise ValueError(
                f"columns has the key {shown(meaning)}; choose of {', '.join(MEANINGS)}"
            )
        wanted = [names] if isinstance(names, str) else list(names)  # type: ignore[call-overload]
        need = 1 if meaning in _SINGLE else 2
        if len(wanted) != need or (unknown := [w for w in wanted if w not in frame.columns]):
            raise ValueError(
                f"columns[{meaning!r}] = {shown(names)}: {need} of {' '.join(frame.columns)} "
                f"{'is' if need == 1 else 'are'} needed"
                + (f", there is no {unknown[0]}" if len(wanted) == need else "")
            )
        at[meaning] = tuple(frame.columns.index(w) for w in wanted)
    if not {"id1", "id2"} <= set(at):
        raise ValueError("columns names no id1 and id2, the grains of a contact")
    vectors = {k: (v[0], v[-1]) for k, v in at.items() if not k.startswith("id")}
    return Columns((at["id1"][0], at["id2"][0]), vectors)


def guessed_ids(frame: Frame, table: Floats, ids: Integers) -> tuple[int, int]:
    """The first two neighbouring columns of whole numbers of grains, in every row two others."""
    known = [np.isin(table[:, k], ids).all() for k in range(table.shape[1])]
    for k in range(table.shape[1] - 1):
        if known[k] and known[k + 1] and (table[:, k] != table[:, k + 1]).all():
            return k, k + 1
    whole = [k for k in range(table.shape[1]) if (table[:, k] == np.round(table[:, k])).all()]
    if len(whole) >= 2:  # ids, of which some are not those of grains
        places(table[:, whole[:2]], ids, frame.text, frame.lines)
    raise frame.text.problem(
        "missing-column",
        f"no two columns of {' '.join(frame.columns)} are ids of grains: say "
        "columns={'id1': ..., 'id2': ...}",
        frame.start - 1,
    )


def guessed_vectors(
    table: Floats, branches: Floats, taken: tuple[int, int]
) -> dict[str, tuple[int, int]]:
    """Neighbouring columns that are a normal or a tangential force, by their direction."""
    r = np.hypot(*branches.T)
    n = branches / r[:, None]
    t = np.column_stack([-n[:, 1], n[:, 0]])
    parts: dict[str, tuple[int, int]] = {}
    for name, wanted, other in (("normal", n, t), ("tangential", t, n)):
        for k in range(table.shape[1] - 1):
            if {k, k + 1} & {*taken, *(c for pair in parts.values() for c in pair)}:
                continue
            v = table[:, k : k + 2]
            along, across = np.sum(v * wanted, axis=1), np.sum(v * other, axis=1)
            size = float(np.sqrt(np.mean(along**2)))
            lengths = np.allclose(np.abs(along), r, rtol=1e-4)  # the line of centres itself
            if size > 0 and not lengths and np.sqrt(np.mean(across**2)) < _PARALLEL * size:
                parts[name] = (k, k + 1)
                break
    if "normal" not in parts:
        return {}
    return parts


def guessed_whole(
    table: Floats, pairs: Integers, taken: tuple[int, int], loads: Floats
) -> dict[str, tuple[int, int]]:
    """Neighbouring columns that are the whole force of a contact: with ``loads`` they balance."""
    count = len(loads)
    for k in range(table.shape[1] - 1):
        F = table[:, k : k + 2]
        size = float(np.hypot(*F.T).mean())
        if {k, k + 1} & set(taken) or not size > 0:
            continue
        net = np.zeros((count, 2))
        np.add.at(net, pairs[:, 0], F)
        np.add.at(net, pairs[:, 1], -F)
        for sign in (1.0, -1.0):
            if np.sqrt(np.mean((sign * net + loads) ** 2)) < _BALANCED * size:
                return {"force": (k, k + 1)}
    return {}


def guess_note(frame: Frame, columns: Columns) -> Note:
    """What was guessed, in words."""
    name = frame.columns
    words = [f"{name[columns.ids[0]]}, {name[columns.ids[1]]} are the grains"]
    for meaning, (a, b) in columns.vectors.items():
        kind = "whole" if meaning == "force" else meaning
        words.append(f"({name[a]}, {name[b]}) is the {kind} force on the first")
    return frame.text.note(
        "information", "guessed", "from the data: " + "; ".join(words), frame.start - 1
    )
