"""VTK's legacy text format: grains as points, contacts as lines between them, for ParaView.

Points are the centres, then, for each contact across a side of the cell or with a wall, the image
of the second centre or the foot on the wall. Point data: radius, id. Cell data: f_n, f_t, overlap
and error bars, 0 on the vertices that stand for the grains. Text of this format needs no library.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.measurement import Measurement
from packing.packing_data import PackingData
from packing.seen import Seen
from packing.writing.tables import Forces


def files(
    target: Path, packing: PackingData | Measurement, forces: Forces, errors: Forces
) -> dict[Path, str]:
    """One file."""
    seen = Seen.of(packing)
    N, c = seen.grains, len(seen.pairs)
    i, j = seen.pairs.T
    far = (j >= N) | seen.images.any(axis=1)
    ends = np.where(far, N + np.cumsum(far) - 1, j)
    x = np.concatenate([seen.positions, (seen.positions[i] + seen.branches)[far]])
    radii = np.zeros(N) if seen.radii is None else seen.radii
    vertices = "\n".join(f"1 {k}" for k in range(N))
    lines = "\n".join(f"2 {a} {b}" for a, b in zip(i.tolist(), ends.tolist(), strict=True))
    parts = [
        "# vtk DataFile Version 3.0",
        "grains and contacts of a packing",
        "ASCII",
        "DATASET POLYDATA",
        f"POINTS {len(x)} double",
        "\n".join(f"{a!r} {b!r} 0" for a, b in x.tolist()),
        f"VERTICES {N} {2 * N}",
        vertices,
    ]
    if c:
        parts += [f"LINES {c} {3 * c}", lines]
    parts += [f"CELL_DATA {N + c}"]
    named = {
        "f_n": forces[0],
        "f_t": forces[1],
        "overlap": seen.overlaps,
        "f_n_error": errors[0],
        "f_t_error": errors[1],
    }
    for name, values in named.items():
        if values is not None:
            parts += _scalars(name, np.concatenate([np.zeros(N), values]))
    extra = len(x) - N
    parts += [f"POINT_DATA {len(x)}"]
    parts += _scalars("radius", np.concatenate([radii, np.zeros(extra)]))
    parts += _scalars("id", np.concatenate([np.arange(N), j[far]]).astype(float))
    return {target: "\n".join(parts) + "\n"}


def _scalars(name: str, values: Floats) -> list[str]:
    numbers = "\n".join(map(repr, values.tolist()))
    return [f"SCALARS {name} double 1", "LOOKUP_TABLE default", numbers]
