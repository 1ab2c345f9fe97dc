"""Contact forces that were measured from both grains: one mean, and the noise between the two.

Photoelastic images give the force of a contact twice, from the fringes of either disk. With the
two readings a and b of one force, the mean has the standard deviation  rms(a - b)/2.  Tangential
readings that have nothing to do with each other (a correlation below one half) measured nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.files.text import Text
from packing.note import Note

_MEASURED = 0.5
"""Correlation of the two readings from which on they measured the same thing."""


@dataclass(frozen=True, eq=False)
class Merged:
    """Contacts i < j, once each; None for f_t that was not measured; notes and uncertainties."""

    pairs: Integers
    normal: Floats
    tangential: Floats | None
    lines: Integers
    uncertainty: dict[str, Any]
    notes: tuple[Note, ...]


def merged(
    pairs: Integers, normal: Floats, tangential: Floats, lines: Integers, text: Text
) -> Merged:
    """The mean of both readings of each contact; one reading where there is one alone.

    FileProblem: the same grain reads one contact twice.
    """
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    if (low == high).any():
        e = int(np.argmax(low == high))
        raise text.problem("damaged", "a grain touches itself", int(lines[e]) - 1)
    side = (pairs[:, 0] == high).astype(np.int64)
    _, first, again = np.unique(
        np.column_stack([low, high, side]), axis=0, return_index=True, return_inverse=True
    )
    again = np.reshape(again, -1)
    if len(first) < len(pairs):
        e = int(np.argmax(first[again] != np.arange(len(pairs))))
        raise text.problem(
            "listed-twice",
            f"the contact is there twice, first in line {lines[first[again[e]]]}",
            int(lines[e]) - 1,
        )
    keys, contact = np.unique(np.column_stack([low, high]), axis=0, return_inverse=True)
    contact = np.reshape(contact, -1)
    readings = np.full((2, len(keys), 2), np.nan)
    readings[0, contact, side], readings[1, contact, side] = normal, tangential
    at = np.full(len(keys), len(lines) + 1)
    np.minimum.at(at, contact, lines)
    both = ~np.isnan(readings[0]).any(axis=1)
    mean = np.nanmean(readings, axis=2)
    if not both.any():
        note = text.note(
            "information", "two-sided", f"each of {len(keys)} contacts was measured from one side"
        )
        return Merged(keys, mean[0], mean[1], at, {}, (note,))
    return _with_noise(Merged(keys, mean[0], mean[1], at, {}, ()), readings[:, both], text)


def _with_noise(m: Merged, readings: Floats, text: Text) -> Merged:
    """The noise between the two readings (2, k, 2) of f_n and f_t."""
    differ = readings[0, :, 0] - readings[0, :, 1]
    scale = float(np.abs(m.normal).mean()) or 1.0
    noise = float(np.sqrt(np.mean(differ**2))) / 2
    a, b = readings[1].T
    follows = float(np.corrcoef(a, b)[0, 1]) if np.std(a) > 0 and np.std(b) > 0 else 0.0
    measured = abs(follows) >= _MEASURED
    words = (
        f"{readings.shape[1]} of {len(m.pairs)} contacts were measured from both sides; the two "
        f"f_n differ by {np.median(np.abs(differ)) / scale:.2g} ⟨f_n⟩ in the median, the two "
        f"f_t have the correlation {follows:.2g}"
        + ("" if measured else ": f_t counts as not measured")
    )
    note = text.note(
        "warning" if not measured else "information",
        "two-sided",
        words,
        None,
        float(np.median(np.abs(differ)) / scale),
    )
    found: dict[str, Any] = {"normal_forces": noise} if noise > 0 else {}
    if measured:
        found["tangential_forces"] = float(np.sqrt(np.mean((a - np.sign(follows) * b) ** 2))) / 2
    return Merged(m.pairs, m.normal, m.tangential if measured else None, m.lines, found, (note,))
