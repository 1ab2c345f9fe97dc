"""Forces as a table: one row a contact, with its ends and an error bar for each component."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from packing_forces.judging.found import Found
from packing_forces.known.case import Case

COLUMNS = (
    "i", "j", "image_x", "image_y", "normal_x", "normal_y", "f_n", "f_n_low", "f_n_high", "f_t",
    "f_t_low", "f_t_high",
)  # fmt: skip


def rows(case: Case, found: Found) -> list[list[float | int | None]]:
    """As COLUMNS say; None where there is no bar."""
    n, c = case.network, case.network.contacts
    none = np.full(2 * c, np.nan)

    def both(values: np.ndarray | None) -> np.ndarray:
        filled = none.copy()
        if values is not None:
            filled[: len(values)] = values
        return filled.reshape(2, c)

    f, low, high = both(found.result.forces), both(found.low), both(found.high)
    table = np.column_stack([n.normals, f[0], low[0], high[0], f[1], low[1], high[1]])
    whole = np.column_stack([n.pairs, n.images]).astype(int).tolist()
    return [
        [*a, *(None if np.isnan(x) else x for x in b)]
        for a, b in zip(whole, table.tolist(), strict=True)
    ]


def write(path: Path, case: Case, found: Found) -> None:
    """The table as CSV, floats with all their digits; contacts (i, N + w) are with wall w."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        out = csv.writer(stream)
        out.writerow(COLUMNS)
        for row in rows(case, found):
            out.writerow("" if x is None else repr(x) for x in row)
