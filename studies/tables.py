"""Tables of results: NAME.csv, whose first line holds the names, and NAME.json, what it is.

np.genfromtxt("figures/fig1.csv", names=True, delimiter=",", dtype=None, encoding="utf-8")
pandas.read_csv("figures/fig1.csv")
"""

from __future__ import annotations

import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from packing.version import __version__


def provenance(**facts: Any) -> dict[str, Any]:
    """Versions and seeds: what it takes to make the table again."""
    versions = {"packing-forces": __version__}
    versions |= {name: version(name) for name in ("numpy", "scipy", "matplotlib")}
    versions |= {"python": platform.python_version()}
    return facts | {"versions": versions}


def structured(columns: dict[str, np.ndarray]) -> np.ndarray:
    """Columns of one length as a structured array."""
    table = np.empty(len(next(iter(columns.values()))), [(k, v.dtype) for k, v in columns.items()])
    for name, values in columns.items():
        table[name] = values
    return table


def write_table(path: Path, table: np.ndarray, facts: dict[str, Any]) -> None:
    """A structured array as CSV, numbers to nine digits, and the ``facts`` beside it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as stream:
        stream.write(",".join(table.dtype.names or ()) + "\n")
        for row in table.tolist():
            stream.write(",".join(f"{v:.9g}" if isinstance(v, float) else str(v) for v in row))
            stream.write("\n")
    text = json.dumps(facts, default=str, ensure_ascii=False, indent=1)
    path.with_suffix(".json").write_text(text + "\n")


def read_table(path: Path) -> np.ndarray:
    """The rows of a CSV as a structured array ``(rows,)``."""
    table = np.genfromtxt(path, names=True, delimiter=",", dtype=None, encoding="utf-8")
    return np.atleast_1d(table)


def read_facts(path: Path) -> dict[str, Any]:
    """What a CSV says of itself."""
    return json.loads(path.with_suffix(".json").read_text())
