"""One look for all figures, and one way to write them: PNG, PDF and the numbers as CSV."""

from __future__ import annotations

import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")  # figures are written, never shown
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from packing.version import __version__

#: Told apart by the colour-blind too (Okabe and Ito).
PALETTE = (
    "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#999999", "#000000",
)  # fmt: skip
COLUMN = 3.4  # inches, the width of one journal column

STYLE = {
    "font.size": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "lines.markersize": 3.5,
    "errorbar.capsize": 1.5,
    "axes.grid": False,
    "axes.prop_cycle": mpl.cycler(color=PALETTE),
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "mathtext.fontset": "dejavusans",
}
mpl.rcParams.update(STYLE)
MARKERS = "osD^v<>"


def new_figure(height: float, rows: int, columns: int = 1, **kwargs: Any) -> tuple[Figure, Any]:
    """A one-column figure and its axes."""
    return plt.subplots(rows, columns, figsize=(COLUMN, height), layout="constrained", **kwargs)


def wide_figure(height: float, rows: int, columns: int = 1, **kwargs: Any) -> tuple[Figure, Any]:
    """A figure over two columns and its axes."""
    size = (2 * COLUMN, height)
    return plt.subplots(rows, columns, figsize=size, layout="constrained", **kwargs)


def colour(delta: float, smallest: float = 1e-6, largest: float = 1e-1) -> tuple[float, ...]:
    """From viridis (readable by the colour-blind and in grey), dark for the stiffest grains."""
    place = np.log(delta / smallest) / np.log(largest / smallest)
    return mpl.colormaps["viridis"](0.9 * place)


def power_of_ten(delta: float) -> str:
    """``10^{-6}`` for 1e-6, as mathtext."""
    return f"10^{{{round(np.log10(delta))}}}"


def one_digit(error: float) -> str:
    """An error bar to one digit: 0.004, 4e-05, 10."""
    return f"{float(f'{error:.1g}'):g}"


def provenance(**facts: Any) -> dict[str, Any]:
    """Versions and seeds: what it takes to make the figure again."""
    versions = {"packing-forces": __version__}
    versions |= {name: version(name) for name in ("numpy", "scipy", "matplotlib")}
    versions |= {"python": platform.python_version()}
    return facts | {"versions": versions}


def write(
    figure: Figure, folder: Path, name: str, table: np.ndarray, facts: dict[str, Any]
) -> list[Path]:
    """PNG, PDF and CSV of one figure; ``facts`` go into the metadata of each."""
    folder.mkdir(parents=True, exist_ok=True)
    note = json.dumps(facts, default=str)
    paths = [folder / f"{name}.{kind}" for kind in ("png", "pdf", "csv")]
    figure.savefig(paths[0], metadata={"Description": note})
    figure.savefig(paths[1], metadata={"Subject": note, "CreationDate": None})
    plt.close(figure)
    write_table(paths[2], table, facts)
    return paths


def write_table(path: Path, table: np.ndarray, facts: dict[str, Any]) -> None:
    """A structured array as CSV, below one comment line with the ``facts``."""
    names = table.dtype.names or ()
    with path.open("w") as stream:
        stream.write(f"# {json.dumps(facts, default=str)}\n{','.join(names)}\n")
        for row in table.tolist():
            stream.write(",".join(f"{v:.9g}" if isinstance(v, float) else str(v) for v in row))
            stream.write("\n")
