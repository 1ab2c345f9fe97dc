"""Dumps as LAMMPS writes them, of packings made here, with as many digits as one likes."""

from __future__ import annotations

import numpy as np

BOX = "ITEM: BOX BOUNDS pp pp pp\n0 {:.17g}\n0 {:.17g}\n-0.5 0.5\n"


def write_dumps(packing, folder, form="%.6g"):
    """atoms.dump and contacts.dump; forces are those on the first grain."""
    box = BOX.format(*np.diag(packing.cell))
    count = len(packing.radii)
    lines = [f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\n{box}"]
    lines.append("ITEM: ATOMS id type radius x y z\n")
    for k, (R, x) in enumerate(zip(packing.radii, packing.positions, strict=True)):
        lines.append(f"{k + 1} 1 {form % R} {form % x[0]} {form % x[1]} 0\n")
    (folder / "atoms.dump").write_text("".join(lines))
    n = packing.branches / abs(packing.branches)
    normal, tangential = -packing.normal_forces * n, 1j * packing.tangential_forces * n
    lines = [f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n{len(n)}\n{box}"]
    columns = " ".join(["c_pl[1] c_pl[2]", *(f"c_pd[{k}]" for k in range(1, 5))])
    lines.append(f"ITEM: ENTRIES index {columns}\n")
    for e, (i, j) in enumerate(packing.pairs):
        values = (normal[e].real, normal[e].imag, tangential[e].real, tangential[e].imag)
        lines.append(f"{e + 1} {i + 1} {j + 1} {' '.join(form % v for v in values)}\n")
    (folder / "contacts.dump").write_text("".join(lines))
    return folder / "atoms.dump", folder / "contacts.dump"
