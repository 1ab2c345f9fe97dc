"""One look for all figures, and one way to write them: as PNG and PDF."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")  # figures are written, never shown
import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from packing_forces.drawing.colours import COLOURS, PALETTE

__all__ = ["COLOURS", "PALETTE", "colour", "new_figure", "power_of_ten", "wide_figure", "write"]

COLUMN = 3.4  # inches, the width of one journal column
DPI = 300
PALETTE_OF_PNG: dict[str, Any] = {
    "method": Image.Quantize.MAXCOVERAGE, "kmeans": 3, "dither": Image.Dither.NONE,
}  # fmt: skip
"""Few colours of thin lines are far off: at most 26 of 255 in Fig. 6, the most colourful."""

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
    "savefig.dpi": DPI,
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


def write(figure: Figure, folder: Path, name: str, facts: dict[str, Any]) -> list[Path]:
    """PNG and PDF of one figure; ``facts`` go into the metadata of both.

    The PNG keeps 256 colours, and with them a third of the bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    note = json.dumps(facts, default=str)
    png, pdf = folder / f"{name}.png", folder / f"{name}.pdf"
    with io.BytesIO() as drawn:
        figure.savefig(drawn, format="png")
        image = Image.open(drawn).convert("RGB").quantize(256, **PALETTE_OF_PNG)
    about = PngInfo()
    about.add_text("Description", note)
    image.save(png, pnginfo=about, optimize=True, dpi=(DPI, DPI))
    figure.savefig(pdf, metadata={"Subject": note, "CreationDate": None})
    plt.close(figure)
    return [png, pdf]
