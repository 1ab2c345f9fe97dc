"""Fig. 8: one collapse for all worlds.

(a) E against ξ/Δ* for noise on the diameters, Δ* = law.delta(p*) with the measured pressure p*,
one point per packing and strength: periodic cells, between walls, in boxes, under weight, for
linear disks and elastic spheres, with μ from 0.03 to 3; lines are E = C ξ/Δ* with the smallest and
the largest C of the table.  (b) Control: the same E against ξ alone.  (c) Control: against ξ over
the Δ of the other law.  (d) C of each world at the smallest Δ, ± standard error over packings.
(e) E without noise when elastic spheres are read as linear, with the stiffness that is best in
hindsight.  (f) C of the layers of packings under weight, with Δ of the layer and of the whole.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper_figs.style import COLOURS, PALETTE, wide_figure
from studies.error_bars import standard_error
from studies.prefactors.worlds import CONTACTS, METHODS, RANGES, WORLDS

TABLES = ("fig8", "fig8_layers")
FACES = {"linear": None, "hertz": "white"}
"""Markers are filled for linear contacts (None), open for elastic spheres."""
NAMES = {"linear": "linear", "hertz": "Hertz"}
SHAPES = "osD^v<>P"


def plot(table: np.ndarray, layers: np.ndarray) -> Figure:
    """Six panels over two columns."""
    figure, ((a, b, c), (d, e, f)) = wide_figure(
        5.2, 2, 3, gridspec_kw={"height_ratios": (1, 1.15)}
    )
    _collapse(a, table, "delta", r"$\xi/\Delta^*$", "(a) noise over deformation")
    low, high = table["C"].min(), table["C"].max()
    x = np.array([6e-4, 0.17])
    for C in (low, high):
        a.plot(x, C * x, "k--", linewidth=0.7)
    a.text(0.05, 0.93, f"$C$ = {low:.2f} to {high:.2f}", transform=a.transAxes, va="top")
    a.set_ylabel("relative error $E$")
    _collapse(b, table, "", r"$\xi$ in mean diameters", "(b) control: noise alone")
    _collapse(c, table, "wrong_delta", r"$\xi/\Delta$, other law", "(c) control: wrong law")
    rows = [(world, 0.3) for world in WORLDS]
    rows += [("rough walls", μ) for μ in sorted(set(table["friction"])) if μ != 0.3]
    smallest = table[table["told_delta"] == table["told_delta"].min()]
    _prefactors(d, smallest, rows)
    _as_linear(e, smallest[smallest["contact"] == "hertz"], rows)
    _layers(f, layers)
    return figure


def _collapse(panel: Axes, table: np.ndarray, scale: str, label: str, title: str) -> None:
    """E against the noise over what `scale` names."""
    for kind in CONTACTS:
        for k, world in enumerate(WORLDS):
            r = table[(table["world"] == world) & (table["contact"] == kind)]
            for name in RANGES:
                xi = r[f"ratio_{name}"] * r["delta"]
                unit = r[scale] if scale else 1.0
                panel.plot(
                    xi / unit, r[f"E_{name}"], linestyle="none",
                    **_look(k, kind) | {"markersize": 2, "markeredgewidth": 0.5},
                )  # fmt: skip
    panel.set(xscale="log", yscale="log", xlabel=label)
    panel.set_title(title, loc="left")


def _look(world: int, kind: str) -> dict[str, Any]:
    colour = PALETTE[world % len(PALETTE)]
    face = FACES[kind] or colour
    return {"color": colour, "marker": SHAPES[world], "markerfacecolor": face, "markersize": 3}


def _prefactors(panel: Axes, table: np.ndarray, rows: list[tuple[str, float]]) -> None:
    for y, (world, friction) in enumerate(rows):
        for kind in CONTACTS:
            C = _row(table[table["contact"] == kind], world, friction)["C"]
            panel.errorbar(
                C.mean(), y, xerr=standard_error(C), **_look([*WORLDS].index(world), kind)
            )
    names = [w if μ == 0.3 else rf"rough, $\mu$ = {μ:g}" for w, μ in rows]
    panel.set_yticks(range(len(rows)), names)
    panel.invert_yaxis()
    panel.set(xlabel="$C$", xlim=(0, None))
    panel.set_title("(d) filled linear, open Hertz", loc="left", x=-0.25)


def _row(table: np.ndarray, world: str, friction: float) -> np.ndarray:
    return table[(table["world"] == world) & (table["friction"] == friction)]


def _as_linear(panel: Axes, table: np.ndarray, rows: list[tuple[str, float]]) -> None:
    for k, method in enumerate(METHODS):
        values = [_row(table, *row)[f"linear_{method}"] for row in rows]
        panel.errorbar(
            [v.mean() for v in values], np.arange(len(rows)) + 0.2 * (k - 1),
            xerr=[standard_error(v) for v in values], linestyle="none",
            marker="osD"[k], color=COLOURS[method], label=method,
        )  # fmt: skip
    panel.set_yticks(range(len(rows)), [""] * len(rows))
    panel.set(xlabel="relative error $E$", xlim=(0, 0.45), ylim=(len(rows) - 0.5, -0.5))
    panel.legend(loc="upper right")
    panel.set_title("(e) Hertz read as linear", loc="left")


def _layers(panel: Axes, layers: np.ndarray) -> None:
    smallest = layers["told_delta"].min()
    for kind, colour in zip(CONTACTS, PALETTE, strict=False):
        for name, scale, style in (("layer", "delta", "-"), ("whole", "whole_delta", ":")):
            r = layers[(layers["contact"] == kind) & (layers["told_delta"] == smallest)]
            height = np.unique(r["layer"])
            values = [_of(r, k, scale) for k in height]
            mean = [v.mean() for v in values]
            error = [standard_error(v) for v in values]
            panel.errorbar(
                mean, height + 1, xerr=error, color=colour, linestyle=style, marker="o",
                markerfacecolor=colour if name == "layer" else "white",
                label=rf"{NAMES[kind]}, $\Delta$ of {name}",
            )  # fmt: skip
    panel.set(xlabel=r"$E\,\Delta/\xi$", ylabel="layer, from below", xlim=(0, None))
    panel.set_ylim(0.6, layers["layer"].max() + 2.9)  # room for the legend
    panel.set_yticks(np.unique(layers["layer"]) + 1)
    panel.legend(loc="upper left")
    panel.set_title("(f) layers under weight", loc="left")


def _of(r: np.ndarray, layer: int, scale: str) -> np.ndarray:
    mine = r[r["layer"] == layer]
    return mine["error_of_xi"] * mine[scale]
