"""Rounding is noise: coordinates with few digits lie on the collapse of E on ξ/Δ.

Positions and radii of packings at several Δ are rounded to k decimals, or stored as float16 and
float32, and reconstructed.  A grid of step h is noise ξ = h/√12; with C_x and C_R the exact
prefactors of position and radius noise, the prediction is E² = (C_x ξ_x/Δ)² + (C_R ξ_R/Δ)².
The abscissa is the ξ/Δ that the two amount to: ξ² = (C_x² ξ_x² + C_R² ξ_R²)/(C_x² + C_R²).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from dem import Packing
from packing.arguments.coordinate_rounding import rounding_noise
from paper_figs.style import MARKERS, new_figure
from scaling import (
    CoarseCoordinatesWarning,
    ContactNetwork,
    amplification_of,
    reconstruct,
    relative_error,
)

KINDS = ("float16", "float32", *(f"{k} decimals" for k in range(2, 10)))
#: Beyond this displacement of a coordinate (in ⟨σ⟩) contacts cross: no packing any more.
COARSEST = 0.02
TABLE = np.dtype([
    ("delta", float), ("seed", int), ("kind", "U12"), ("xi", float), ("ratio", float),
    ("error", float), ("predicted", float),
])  # fmt: skip


def rounded(values: np.ndarray, kind: str) -> np.ndarray:
    """``values`` as they come back from a file of that kind."""
    if kind.endswith("decimals"):
        return np.round(values, int(kind.split()[0]))
    return values.astype(kind).astype(float)


def compute(packings: Iterable[Packing], kinds: Iterable[str] = KINDS) -> np.ndarray:
    """One row per packing and kind of rounding."""
    rows: list[tuple[Any, ...]] = []
    kinds = list(kinds)
    for p in packings:
        # Into the cell, as a file has them; the images follow.
        sides = np.diag(p.cell)
        jump = -np.floor(p.positions / sides).astype(int)
        x = p.positions + jump * sides
        i, j = p.pairs.T
        images = p.images + jump[i] - jump[j]
        C = [amplification_of(p, noise=noise) for noise in ("position", "radius")]
        for kind in kinds:
            xis = np.array([rounding_noise(x, kind), rounding_noise(p.radii, kind)])
            if xis.max() > COARSEST:
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", CoarseCoordinatesWarning)  # it is what is studied
                network = ContactNetwork(
                    rounded(x, kind), rounded(p.radii, kind), p.pairs, cell=p.cell, images=images
                )
            found = reconstruct(network, p.stiffness)
            predicted = float(np.hypot(*(C * xis))) / p.delta
            xi = predicted * p.delta / float(np.hypot(*C))
            rows.append((
                p.delta, p.provenance.seed, kind, xi, xi / p.delta,
                relative_error(found, p), predicted,
            ))  # fmt: skip
    return np.array(rows, TABLE)


def plot(table: np.ndarray) -> Figure:
    """E against the number of decimals (fans out) and against ξ/Δ (one line)."""
    figure, (a, b) = new_figure(4.6, 2)
    deltas = np.unique(table["delta"])[::-1]
    for delta, marker in zip(deltas, MARKERS, strict=False):
        mine = table[table["delta"] == delta]
        decimal = np.char.endswith(mine["kind"], "decimals")
        label = rf"$\Delta=10^{{{round(np.log10(delta))}}}$"
        (line,) = a.plot(
            [int(k.split()[0]) for k in mine["kind"][decimal]], mine["error"][decimal],
            marker, label=label,
        )  # fmt: skip
        colour = line.get_color()
        b.plot(mine["ratio"][decimal], mine["error"][decimal], marker, color=colour)
        for kind, face in (("float32", "none"), ("float16", "k")):
            some = mine["kind"] == kind
            b.plot(
                mine["ratio"][some], mine["error"][some], marker, color=colour,
                markerfacecolor=face, markersize=6,
            )  # fmt: skip
    ends = np.array([table["ratio"].min(), table["ratio"].max()])
    slope = np.median(table["predicted"] / table["ratio"])
    b.plot(ends, slope * ends, "k-", lw=0.7, label=rf"${slope:.2f}\,\xi/\Delta$")
    a.set(yscale="log", xlabel="decimals of the coordinates", ylabel="error $E$ of the forces")
    b.set(
        xscale="log", yscale="log", xlabel=r"$\xi/\Delta$,  $\xi$ = grid step$/\sqrt{12}$",
        ylabel="error $E$ of the forces",
    )  # fmt: skip
    a.legend(loc="upper right", ncol=2)
    b.plot([], [], "o", color="0.4", label="decimals")
    b.plot([], [], "o", color="0.4", markerfacecolor="none", markersize=6, label="float32")
    b.plot([], [], "o", color="0.4", markerfacecolor="k", markersize=6, label="float16")
    b.legend(loc="upper left")
    return figure
