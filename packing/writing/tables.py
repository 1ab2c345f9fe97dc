"""Tables of grains and contacts, which `packing.files.formats.plain` reads back bit for bit.

Numbers are written so that they come back as the same doubles; low parts are not in a table.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing.contact_law import Hertz, Linear
from packing.files.formats.plain.grain_table import CONTACTS, GRAINS
from packing.measurement import Measurement
from packing.packing_data import PackingData
from packing.seen import Seen

Forces = tuple[Floats | None, Floats | None]
"""f_n and f_t."""


def files(
    target: Path, packing: PackingData | Measurement, forces: Forces, errors: Forces
) -> dict[Path, str]:
    """NAME.grains.csv and, if there are contacts, NAME.contacts.csv."""
    stem = target.name.removesuffix(GRAINS).removesuffix(".csv")
    found = {target.with_name(stem + GRAINS): _grains(packing)}
    if packing.pairs is not None:
        found[target.with_name(stem + CONTACTS)] = _contacts(packing, forces, errors)
    return found


def _grains(p: PackingData | Measurement) -> str:
    unit = getattr(p, "length_unit", "")
    suffix = f" [{unit}]" if unit else ""
    columns: dict[str, Any] = {"id": np.arange(len(p.positions))}
    columns |= {f"x{suffix}": p.positions[:, 0], f"y{suffix}": p.positions[:, 1]}
    if p.radii is not None:
        columns[f"r{suffix}"] = p.radii
    if p.external is not None:
        columns |= dict(zip(("fx", "fy", "torque"), p.external.T, strict=True))
    if p.walls is not None and p.walls.glued is not None:
        columns["glued"] = p.walls.glued
    return "".join(f"# {line}\n" for line in _facts(p)) + _table(columns)


def _facts(p: PackingData | Measurement) -> list[str]:
    lines = ["grains of a packing"]
    if p.cell is not None:
        lines.append("cell: " + " ".join(map(_number, np.ravel(p.cell))))
    told = {"stiffness": p.stiffness, "pressure": p.pressure, "friction": p.friction}
    told["stiffness_ratio"] = getattr(p, "stiffness_ratio", None)
    lines += [f"{name}: {_number(value)}" for name, value in told.items() if value is not None]
    law = _law(p)
    if isinstance(law, Linear):
        lines.append("law: linear")
    elif isinstance(law, Hertz):
        lines.append(f"law: hertz {_number(law.stiffness)} {_number(law.poisson)}")
    if p.walls is not None:
        for k, n in enumerate(p.walls.normals):
            lines.append(f"wall {k}: " + " ".join(map(_number, (*n, p.walls.offsets[k]))))
            if not np.isnan(p.walls.loads[k]):
                lines.append(f"load {k}: {_number(p.walls.loads[k])}")
        if p.walls.spaced:
            lines.append("spaced: 1")
    return lines


def _law(p: PackingData | Measurement) -> Any:
    try:
        return p.law
    except ValueError:  # a law of somebody else's, which no file knows
        return None


def _contacts(p: PackingData | Measurement, forces: Forces, errors: Forces) -> str:
    assert p.pairs is not None
    seen = Seen.of(p)
    i, j = p.pairs.T
    columns: dict[str, Any] = {"i": i, "j": np.where(j < seen.grains, j, seen.grains - j - 1)}
    columns |= {"mx": seen.images[:, 0], "my": seen.images[:, 1]}
    if seen.measured is not None:
        columns |= {"nx": seen.measured[:, 0], "ny": seen.measured[:, 1]}
    overlaps = p.overlaps if isinstance(p, PackingData) else seen.overlaps
    unit = getattr(p, "force_unit", "")
    suffix = f" [{unit}]" if unit else ""
    named = {
        "overlap": overlaps,
        f"fn{suffix}": forces[0],
        f"ft{suffix}": forces[1],
        "fn_error": errors[0],
        "ft_error": errors[1],
    }
    columns |= {name: values for name, values in named.items() if values is not None}
    return "# contacts: force on i is -fn n + ft t, wall w is -(w + 1)\n" + _table(columns)


def _table(columns: dict[str, Any]) -> str:
    rows = zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
    lines = [",".join(map(_number, row)) for row in rows]
    return "\n".join([f"# rows: {len(lines)}", ",".join(columns), *lines]) + "\n"


def _number(value: Any) -> str:
    return repr(value) if isinstance(value, int) else repr(float(value))
