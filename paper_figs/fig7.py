"""Fig. 7: what breaks first in an experiment.

(a) Contacts read off noisy positions: false and missed ones at the threshold that gets
fewest wrong, as fractions of the true number, means over packings.  (b) The error with the list
known, and inferred, averaged over the union of both lists, with force 0 where a contact is in one
only: for gppsz with that threshold; for `bounded`, whose contacts may then be open, with the
better of two thresholds in hindsight, that is by the true error (none is feasible where too many
contacts are missed); and without any hindsight, each pair closed with the probability that the
gaps alone give it (dotted).  (c) A wrong scale
of the radii, and rounding of radii or of coordinates; the CSV also has spread stiffness.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import COLOURS, MARKERS, new_figure, power_of_ten
from studies.experiment.experiment_errors import DELTA, DELTAS

TABLES = ("fig7",)


def plot(table: np.ndarray) -> Figure:
    """Three panels of one column."""
    figure, (a, b, c) = new_figure(6.6, 3)
    contacts = table[table["study"] == "contacts"]
    for kind, marker in (("false", "s"), ("missed", "o")):
        mine = np.sort(contacts[contacts["method"] == kind], order="ratio")
        a.errorbar(
            mine["ratio"], mine["value"], mine["value_sd"], marker=marker, label=kind,
            color="#D55E00" if kind == "false" else "#0072B2",
        )  # fmt: skip
    a.set(xscale="log", ylabel="share of contacts", ylim=(0, None))
    a.set_title(rf"(a) contacts misread, $\Delta={power_of_ten(DELTA)}$", loc="left")
    a.legend(loc="upper left")
    named = {"known": "list known", "inferred": "best list", "from gaps": "no list"}
    for method in ("gppsz", "bounded"):
        for kind, style in (("known", "-"), ("inferred", "--"), ("from gaps", ":")):
            if f"{method} {kind}" not in contacts["method"]:
                continue
            mine = np.sort(contacts[contacts["method"] == f"{method} {kind}"], order="ratio")
            b.errorbar(
                mine["ratio"], mine["value"], mine["value_sd"], linestyle=style, marker="o",
                color=COLOURS[method], label=f"{method}, {named[kind]}", markerfacecolor="white",
            )  # fmt: skip
    b.set(xscale="log", yscale="log", ylabel="relative error $E$")
    b.set_title("(b) error with contacts known and inferred", loc="left")
    b.legend(loc="upper left")
    b.set_xlabel(r"noise on positions over deformation $\xi/\Delta$")
    calibration = table[table["study"] == "calibration"]
    colours = {
        "scale direct": "#999999", "rounding centres": "#CC79A7", "rounding": "#0072B2",
        "scale gppsz": "#D55E00",
    }  # fmt: skip
    labels = {
        "scale direct": "scale of radii, direct", "rounding": "rounded radii, gppsz",
        "rounding centres": "rounded centres, gppsz",
        "scale gppsz": "scale of radii, gppsz",
    }  # fmt: skip
    for name, colour in colours.items():
        for delta, marker in zip(DELTAS, MARKERS, strict=False):
            mine = calibration[(calibration["method"] == name) & (calibration["delta"] == delta)]
            c.errorbar(
                mine["ratio"], mine["value"], mine["value_sd"], color=colour, marker=marker,
                linestyle="none", markerfacecolor="white",
                label=labels[name] if delta == DELTA else None,
            )  # fmt: skip
    C = calibration[(calibration["method"] == "C") & (calibration["delta"] == DELTA)]["value"][0]
    x = np.array([1e-2, 1e3])
    c.plot(x, C * x, "k--", linewidth=0.8, label=r"$C\,\xi/\Delta$")
    c.set(
        xscale="log", yscale="log", ylabel="relative error $E$",
        xlabel=r"size error over deformation, $\varepsilon/\Delta$ or $\xi/\Delta$",
    )  # fmt: skip
    c.set_ylim(1e-8, 1e9)  # room for the legend
    c.set_title(r"(c) scale, rounding; $\Delta=10^{-6}$ ○, $10^{-4}$ □, $10^{-2}$ ◇", loc="left")
    c.legend(loc="upper left")
    return figure
