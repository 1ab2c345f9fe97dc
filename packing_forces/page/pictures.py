"""Pictures that stand in the page itself: PNG as data, curves as SVG."""

from __future__ import annotations

import base64
import html
import io

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image

from packing.arguments.arrays import Floats
from packing_forces.drawing.chains import plot
from packing_forces.known.case import Case

DPI, COLOURS = 150, 64
"""Of pictures; so many colours are enough for thin lines, and a third of the bytes."""


def png(figure: Figure, alt: str) -> str:
    """An ``img`` element with the picture in it."""
    with io.BytesIO() as stream, io.BytesIO() as small:
        figure.savefig(stream, format="png", dpi=DPI)
        Image.open(stream).convert("RGB").quantize(COLOURS).save(small, "png", optimize=True)
        data = base64.b64encode(small.getvalue()).decode()
    return f'<img alt="{html.escape(alt)}" src="data:image/png;base64,{data}">'


def svg(figure: Figure, alt: str) -> str:
    """An ``svg`` element that scales with the page; its text stays text."""
    with io.StringIO() as stream, rc_context({"svg.fonttype": "none", "svg.hashsalt": "report"}):
        figure.savefig(stream, format="svg", metadata={"Date": None})
        drawn = stream.getvalue()
    drawn = drawn[drawn.index("<svg") :]
    return drawn.replace("<svg", f'<svg role="img" aria-label="{html.escape(alt)}"', 1)


def chains(case: Case, forces: Floats, scale: float, alt: str) -> str:
    """Force chains; lines of one scale can be compared between pictures."""
    figure = Figure(figsize=(5, 5), layout="constrained")
    plot(case.network, forces, axes=figure.subplots(), scale=scale)
    return png(figure, alt)


def errors(case: Case, forces: Floats, per_contact: Floats, label: str, alt: str) -> str:
    """Contacts as wide as their force, coloured by their error."""
    figure = Figure(figsize=(5.8, 5), layout="constrained")
    plot(case.network, np.abs(forces), axes=figure.subplots(), values=per_contact, label=label)
    return png(figure, alt)
