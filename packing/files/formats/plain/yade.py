"""Text export of YADE: ``#format x_y_z_r`` and a row for each sphere; contacts in a table.

`yade.export.textExt` writes no contacts. A loop over ``O.interactions`` that writes a header and

    id1 id2 fnx fny fsx fsy        phys.normalForce and phys.shearForce, which act on id2

makes the table that is read here; see `packing.files.formats.plain.contact_table`.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from packing.arguments.numbers import file_path
from packing.files.formats.plain.columns import table_of
from packing.files.formats.plain.grain_table import snapshot_of
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot

NAME = "yade"
_FORMAT = re.compile(r"#format\s+(x_y_z_r\w*)")
_COLUMNS = ("x", "y", "z", "r")


def recognises(path: Path, head: str) -> bool:
    """By the first line."""
    return bool(_FORMAT.match(head))


def read(path: Path, *, contacts: Any = None) -> Snapshot:
    """The spheres, which have to lie in a plane, and a table of contacts.

    Parameters
    ----------
    path : Path
        What `yade.export.text` or `textExt` wrote.
    contacts : path, optional
        A table with a header: id1, id2, fnx, fny, fsx, fsy.
    """
    text = text_of(path)
    match = _FORMAT.match(text.lines[0])
    if match is None:
        raise text.problem("damaged", "the first line is not '#format x_y_z_r'", 0)
    comments = [k for k, line in enumerate(text.lines) if line.startswith("#")]
    named: tuple[str, ...] = _COLUMNS
    if match[1] == "x_y_z_r_matId":
        named = (*_COLUMNS, "material")
    elif match[1] == "x_y_z_r_attrs":
        named = (*_COLUMNS, *text.lines[comments[-1]].lstrip("#").split())
    rows = [line for line in text.lines if not line.startswith("#")]
    if not rows:
        raise text.problem("no-grains", "there is no sphere", len(text.lines) - 1, 0)
    other = None if contacts is None else file_path("contacts", contacts)
    return snapshot_of(table_of(text, named), other)
