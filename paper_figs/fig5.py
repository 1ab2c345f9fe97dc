"""Fig. 5: the prefactor C = E/(ξ/Δ) of every estimator against Δ, and the laws behind it.

C = K p/⟨|f|⟩.  (a) Noise on the diameters, (b) on the positions.  (c) With friction the gain
of gppsz for size noise, K² over loops per contact, is a function of the coordination Z (and grows
as 1 + 9.5/N in small packings); the constant ½ is near it by cancellation and is no law, see
`scaling.uncertainty.prefactor`.  (d) The bound for position noise is near K = 2.7 ⟨σ⟩ times the
hyperstaticity per unknown, h/2c, save close to isostaticity.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from dem import Packing
from paper_figs.fig4 import COLOURS
from paper_figs.packings import DELTAS, Edition
from paper_figs.style import colour, provenance, wide_figure
from scaling import ContactNetwork, error_map, force_equation, mean_force

PROBES = 12
SEED = 5
LOOP_LAW, BOUND_LAW = 0.5, 2.7
#: K²/⟨σ⟩² over loops per contact as a polynomial in Z, highest power first: fitted to 18 packings
#: of 300 grains with other friction, Δ and sizes, none of them drawn here; and b of its growth
#: 1 + b/N towards small packings, 8.9 ± 0.7 to 10.2 ± 1.0 (docs/estimators.md).
CURVE, CURVE_GRAINS, SIZE = (0.0622, -0.5047, 1.5015), 300, 9.5
MAPS = tuple(
    (method, noise)
    for noise in ("diameter", "position")
    for method in ("gppsz", "balanced", "direct", "optimal")
)
TABLE = np.dtype(
    [
        ("delta", float), ("friction", float), ("grains", int), ("seed", int), ("Z", float),
        ("hyperstaticity", float), ("loops", float), ("p_over_f", float),
        *((f"K_{m}_{n}", float) for m, n in MAPS),
        *((f"bar_{m}_{n}", float) for m, n in MAPS),
    ]
)  # fmt: skip


def row(p: Packing) -> tuple:
    """Everything about one packing: coordination, counts per unknown, gains with their bars."""
    network, frictional = ContactNetwork.from_packing(p), p.friction > 0
    equation = force_equation(network, frictional)
    gains = []
    for method, noise in MAPS:
        true = {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}
        found = error_map(network, method, noise, frictional=frictional, **true)
        gains.append(found.estimated_gain(np.random.default_rng(SEED), PROBES))
    K, bars = zip(*gains, strict=True)
    return (
        p.delta, p.friction, len(network.active), p.info["seed"], network.coordination,
        equation.hyperstaticity / equation.unknowns, network.faces / network.contacts,
        p.pressure / mean_force(p), *K, *bars,
    )  # fmt: skip


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """One row per packing, half of those of each Δ."""
    return np.array([row(p) for p in chosen(packings, edition)], TABLE)


def chosen(packings: Sequence[Packing], edition: Edition) -> list[Packing]:
    """The first half of the packings of each Δ."""
    count = max(2, edition.packings // 2)
    return [p for d in DELTAS for p in [q for q in packings if q.delta == d][:count]]


def plot(table: np.ndarray) -> Figure:
    """Two by two panels over two columns."""
    figure, ((a, b), (c, d)) = wide_figure(5.2, 2, 2)
    for axes, noise, title in ((a, "diameter", "(a) diameters"), (b, "position", "(b) positions")):
        for method in ("gppsz", "balanced", "direct", "optimal"):
            means, deviations = [], []
            deltas = np.unique(table["delta"])
            for delta in deltas:
                mine = table[table["delta"] == delta]
                C = mine[f"K_{method}_{noise}"] * mine["p_over_f"]
                means.append(C.mean())
                deviations.append(C.std(ddof=1))
            label = method if method != "optimal" else "optimal = bound"
            axes.errorbar(
                deltas, means, deviations, marker="o", color=COLOURS[method], label=label
            )
        axes.set(xscale="log", xlabel=r"deformation $\Delta$", ylabel="prefactor $C$")
        axes.set_ylim(bottom=-0.03)
        axes.set_title(title + " noisy", loc="left")
    a.legend(loc="upper left")
    a.text(
        0.03, 0.1, "exact positions,\n" r"$Z\leq 4-4/N$: bound 0", transform=a.transAxes,
        fontsize=6.5,
    )  # fmt: skip
    law = table["K_gppsz_diameter"] ** 2 / table["loops"]
    bars = 2 * table["K_gppsz_diameter"] * table["bar_gppsz_diameter"] / table["loops"]
    for one, value, bar in zip(table, law, bars, strict=True):
        c.errorbar(one["Z"], value, bar, marker="o", color=colour(one["delta"]))
        d.errorbar(
            one["hyperstaticity"], one["K_optimal_position"], one["bar_optimal_position"],
            marker="o", color=colour(one["delta"]),
        )  # fmt: skip
    Z = np.linspace(3.1, 4.95, 50)
    c.plot(Z, curve(Z, np.median(table["grains"])), color="k", linewidth=0.8, label="fit in $Z$")
    c.axhline(LOOP_LAW, color="k", linestyle="--", linewidth=0.8, label="½: no law")
    c.set(
        xlabel="coordination $Z$", ylabel=r"$K^2/\langle\sigma\rangle^2\;/\;(1-2/Z)$",
        ylim=(0.44, max(0.58, 1.03 * (law + bars).max())),
    )  # fmt: skip
    c.legend(loc="upper center")
    d.axline((0, 0), slope=BOUND_LAW, color="k", linestyle="--", linewidth=0.8, label="2.7 h/2c")
    d.legend(loc="upper left")
    c.set_title("(c) gppsz, noise on diameters", loc="left")
    d.set(xlabel=r"hyperstaticity per unknown $h/2c$", ylabel=r"$K/\langle\sigma\rangle$")
    d.set(xlim=(0, None), ylim=(0, None))
    d.set_title(r"(d) bound, noise on positions", loc="left")
    return figure


def curve(coordination: np.ndarray, grains: float) -> np.ndarray:
    """The fitted K²/⟨σ⟩² over loops per contact."""
    return np.polyval(CURVE, coordination) * (1 + SIZE / grains) / (1 + SIZE / CURVE_GRAINS)


def laws(table: np.ndarray) -> dict[str, tuple[float, float]]:
    """Coefficients and their standard deviation over packings: (mean, sd) per candidate law."""
    K, B, P = (table[f"K_{n}"] for n in
               ("gppsz_diameter", "balanced_diameter", "optimal_position"))  # fmt: skip
    h, loops = table["hyperstaticity"], table["loops"]
    laws = {
        "gppsz K² / loops per contact": K**2 / loops,
        "gppsz K² / hyperstaticity": K**2 / h,
        "balanced K² / hyperstaticity": B**2 / h,
        "balanced K² / loops per contact": B**2 / loops,
        "bound (positions) K / hyperstaticity": P / h,
        "bound (positions) K² / hyperstaticity": P**2 / h,
    }
    return {k: (float(v.mean()), float(v.std(ddof=1))) for k, v in laws.items()}


def text(table: np.ndarray) -> str:
    """C of every estimator per Δ, for noise on diameters and then on positions, as Markdown."""
    lines = [
        "| Δ | Z | gppsz | balanced | direct | optimal = bound |",
        "|---|---|---|---|---|---|",
    ]
    for delta in np.unique(table["delta"])[::-1]:
        mine = table[table["delta"] == delta]
        cells = [
            ", ".join(
                _bar(mine[f"K_{m}_{n}"] * mine["p_over_f"]) for n in ("diameter", "position")
            )
            for m in ("gppsz", "balanced", "direct", "optimal")
        ]
        lines.append(
            f"| {delta:g} | {mine['Z'].mean():.2f} ± {mine['Z'].std(ddof=1):.2f} | "
            + " | ".join(cells)
            + " |"
        )
    return "\n".join(lines)


def _bar(values: np.ndarray) -> str:
    """Mean ± standard deviation; 0 where nothing but rounding is left."""
    if values.mean() < 1e-6:
        return "0"
    return f"{values.mean():.3f} ± {values.std(ddof=1):.3f}"


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the metadata say."""
    return provenance(
        figure="5", edition=edition.name, grains=edition.grains, probe_seed=SEED, probes=PROBES,
        packing_seeds=[p.info["seed"] for p in chosen(packings, edition)],
        error_bars="(a, b) standard deviation over packings; (c, d) of the probes' mean",
    )  # fmt: skip
