"""Does a change leave the results alone?  Packings bit for bit, tables to nine digits.

    git worktree add ../before COMMIT
    (cd ../before && PYTHONPATH=. python ../main/tests/unchanged.py freeze ../main/build/before)
    PYTHONPATH=. python tests/unchanged.py freeze build/after
    python tests/unchanged.py compare build/before build/after

Freezing makes 24 packings with the NumPy backend (Δ from 1e-10 to 0.1, friction from 0 to 10,
8 to 400 grains, among them ones continued, ramped, unlike in size and in flat cells) and the quick
edition of every figure, with public names only, so that it runs on any commit.  Comparing asks for
equal arrays, and for equal numbers in the tables to 1e-9 (1e-6 in rows of `bounded`, which ends at
the tolerance of a convex solver).  What a table says about itself does not count.
"""

from __future__ import annotations

import csv
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

NUMPY = {"backend": "numpy"}
WORLDS = (
    *({"grains": 100, "delta": d} for d in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
    *({"grains": 100, "delta": d, "friction": 0.0} for d in (1e-1, 1e-2, 1e-3, 1e-4)),
    *({"grains": 64, "delta": 1e-3, "friction": f} for f in (0.01, 0.1, 1.0, 10.0)),
    *({"grains": n, "delta": 1e-2} for n in (8, 16, 400)),
    {"grains": 400, "delta": 1e-4},
    {"grains": 64, "delta": 1e-2, "polydispersity": 0.0},
    {"grains": 64, "delta": 1e-2, "polydispersity": 0.6},
    {"grains": 64, "delta": 1e-2, "aspect": 4.0},
    {"grains": 64, "delta": 1e-2, "stiffness_ratio": 1.0},
    {"grains": 48, "delta": 1e-10},
)
ARRAYS = (
    "positions", "radii", "cell", "pairs", "images", "normal_forces", "tangential_forces",
    "external", "stiffness", "pressure", "friction", "positions_low", "radii_low", "cell_low",
)  # fmt: skip
RTOL, RTOL_BOUNDED = 1e-9, 1e-6
_RATIOS = {"0.01": "hundredth", "1": "equal", "100": "hundredfold"}
RENAMED = {f"{kind}at_{r}": f"{kind}{n}" for kind in ("", "E_") for r, n in _RATIOS.items()}
"""Columns that had a number for a name, which not every reader takes for one."""


def freeze(folder: Path) -> None:
    """Write packings and tables of the code in the current folder to ``folder``."""
    from dem import Scene, Settings, ramp, relax

    folder.mkdir(parents=True, exist_ok=True)
    settings = Settings(**NUMPY)
    packings = [relax(Scene(**w), seed, settings=settings) for seed, w in enumerate(WORLDS)]
    packings.append(ramp(packings[3], [1e-3, 1e-2, 1e-3], settings=settings)[-1])
    for k, packing in enumerate(packings):
        held = {name: getattr(packing, name) for name in ARRAYS}
        there = {name: value for name, value in held.items() if value is not None}
        np.savez(folder / f"packing{k:02}.npz", **there)
    for tables in (Path("build/figures"), Path("build/packings")):
        shutil.rmtree(tables, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "paper_figs"], check=True, env=os.environ)
    for table in Path("build/figures").glob("*.csv"):
        shutil.copy(table, folder)


def compare(before: Path, after: Path) -> list[str]:
    """What differs, in words; nothing if all is the same."""
    wrong = []
    names = sorted(p.name for p in before.iterdir() if p.suffix in (".npz", ".csv"))
    if not names:
        raise ValueError(f"{before} holds nothing to compare with")
    for name in names:
        if not (after / name).exists():
            wrong.append(f"{name}: missing")
        elif name.endswith(".npz"):
            wrong += _packings(before / name, after / name)
        else:
            wrong += _tables(before / name, after / name)
    return wrong


def _packings(before: Path, after: Path) -> list[str]:
    with np.load(before) as old, np.load(after) as new:
        if sorted(old) != sorted(new):
            return [f"{before.name}: {sorted(old)} became {sorted(new)}"]
        return [f"{before.name}: {k} differs" for k in old if not np.array_equal(old[k], new[k])]


def _tables(before: Path, after: Path) -> list[str]:
    """Columns by name: those of before have to be there, in the same rows."""
    old, new = (_rows(path) for path in (before, after))
    if len(old) != len(new):
        return [f"{before.name}: {len(old)} rows became {len(new)}"]
    for k, (a, b) in enumerate(zip(old, new, strict=True)):
        rtol = RTOL_BOUNDED if any("bounded" in word for word in a.values()) else RTOL
        for name, value in a.items():
            now = b.get(name, b.get(RENAMED.get(name, ""), "nothing"))
            if not _same(value, now, rtol):
                return [f"{before.name}, row {k}: {name} = {value} became {now}"]
    return []


def _rows(path: Path) -> list[dict[str, str]]:
    """Rows by the names of their columns; what a table says about itself is left out."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def _same(a: str, b: str, rtol: float) -> bool:
    try:
        x, y = float(a), float(b)
    except ValueError:
        return a == b
    return math.isclose(x, y, rel_tol=rtol) or (math.isnan(x) and math.isnan(y))


def main(words: list[str]) -> None:
    """Freeze, or compare and say what differs."""
    if len(words) == 2 and words[0] == "freeze":
        freeze(Path(words[1]).resolve())
    elif len(words) == 3 and words[0] == "compare":
        wrong = compare(Path(words[1]), Path(words[2]))
        sys.exit("\n".join(wrong) or 0)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    sys.path[0] = os.getcwd()  # the code in the current folder, not what lies beside this file
    main(sys.argv[1:])
