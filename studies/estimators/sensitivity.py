"""Sensitivity of `bounded` to what it is told: friction, pressure, and how good the data are.

What is wrong is told as if it were exact, and then with its error bar, or as unknown. Beside it
`optimal`, which needs none of it, alone and told the mean stress.

Noise on positions. Refused: the solver certifies that no forces satisfy all conditions; open: it
found neither forces nor a certificate. A warning says that the noise needed is not what was told;
without data (ξ = ∞) there is none to tell.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from dem import Packing, Scene
from scaling import ContactNetwork, perturb, reconstruct, relative_error, stress
from scaling.estimators.misfit import ImplausibleNoiseWarning
from scaling.noise.told_noise import UNKNOWN
from studies.error_bars import bar
from studies.packing_store import SEED, make, net

TOLD: dict[str, dict[str, Any]] = {
    "the truth": {},
    "μ = 0.25 for 0.3": {"friction": 0.25 / 0.3},
    "μ = 0.6 for 0.3": {"friction": 2.0},
    "p 5 % too high": {"pressure": 1.05},
    "ξ three times": {"xi": 3.0},
    "ξ a third": {"xi": 1 / 3},
    "μ = 0.25 ± 0.05": {"friction": (0.25 / 0.3, 0.05 / 0.3)},
    "μ unknown": {"friction": UNKNOWN},
    "p 5 % too high ± 5 %": {"pressure": (1.05, 0.05)},
    "p unknown": {"pressure": UNKNOWN},
    "ξ unknown": {"xi": UNKNOWN},
    "p ± 5 % and μ and ξ unknown": {
        "pressure": (1.05, 0.05), "friction": UNKNOWN, "xi": UNKNOWN,
    },
    "optimal": {"method": "optimal"},
    "optimal and the stress": {"method": "optimal", "stress": True},
    "the truth and the stress": {"stress": True},
}  # fmt: skip
"""Factors on what is true, with the factors of their deviations; the method if another."""
RATIOS = (0.1, 1.0, 10.0, np.inf)
LARGEST_XI = 0.05
DELTAS = (1e-2, 1e-4)
COUNT = 8
TABLE = np.dtype([
    ("delta", float), ("told", "U40"), ("ratio", float), ("seed", int), ("error", float),
    ("outcome", "U7"), ("warned", bool),
])  # fmt: skip


def measure(
    p: Packing, noisy: ContactNetwork, xi: float, factors: dict[str, Any]
) -> tuple[float, str, bool]:
    """(E, outcome, warned) of what is told factors times the truth; E is nan if there is none.

    Outcomes: "found"; "refused" and "open", see above; "none" where there is nothing to ask:
    without data for `optimal`, ξ and a pressure that only they could tell.
    """
    method, truth = factors.get("method", "bounded"), {"xi": xi}
    if not np.isfinite(xi) and (
        method == "optimal" or factors.get("pressure") == UNKNOWN or list(factors) == ["xi"]
    ):
        return np.nan, "none", False
    if method == "bounded":
        truth |= {"friction": p.friction, "pressure": p.pressure}
    told: dict[str, Any] = dict(truth)
    for name, factor in factors.items():
        if name in truth and not (name == "xi" and not np.isfinite(xi)):
            told[name] = _times(factor, truth[name])
    if "stress" in factors:
        σ = stress(net(p), p.forces)
        told["stress"] = {"xx": σ[0, 0], "xy": σ[0, 1], "yy": σ[1, 1]}
        told.pop("pressure", None)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", ImplausibleNoiseWarning)
        try:
            found = reconstruct(noisy, p.stiffness, method, noise="position", **told)
        except ValueError as refusal:
            if "no forces satisfy" not in str(refusal):
                raise
            return np.nan, "refused", False
        except RuntimeError:
            return np.nan, "open", False
    return relative_error(found, p), "found", bool(said)


def _times(factor: Any, truth: float) -> Any:
    if isinstance(factor, tuple):
        return tuple(f * truth for f in factor)
    return factor if factor == UNKNOWN else factor * truth


def compute(grains: int = 300, count: int = COUNT) -> np.ndarray:
    """Every Δ, statement, ξ/Δ and packing, all statements on the same noise."""
    rows = []
    for delta in DELTAS:
        for seed, p in enumerate(make([Scene(grains, delta)] * count, range(count))):
            for ratio in RATIOS:
                if LARGEST_XI < ratio * delta < np.inf:
                    continue
                xi, noisy = ratio * delta, net(p)
                if np.isfinite(xi):
                    rng = np.random.default_rng([SEED, seed])
                    noisy = perturb(noisy, xi, rng, "position")
                for name, factors in TOLD.items():
                    rows.append((delta, name, ratio, seed, *measure(p, noisy, xi, factors)))
    return np.array(rows, TABLE)


def cell(mine: np.ndarray) -> str:
    """Mean ± standard error over what was found, and how often it was not, or was noticed."""
    mine = mine[mine["outcome"] != "none"]
    if not len(mine):
        return ""
    found, count = mine[mine["outcome"] == "found"], len(mine)
    notes = {name: int((mine["outcome"] == name).sum()) for name in ("refused", "open")}
    if notes["refused"] == count:
        return "refused"
    notes["warned"] = int(mine["warned"].sum())
    said = [f"{k} of {count} {name}" for name, k in notes.items() if k]
    if not len(found):
        return ", ".join(said)
    value = bar(found["error"]) if len(found) > 1 else f"{found['error'][0]:.3f}"
    return value + (f" ({', '.join(said)})" if said else "")


def text(table: np.ndarray) -> str:
    """A line per Δ and statement."""
    head = "| Δ | told | " + " | ".join(f"ξ/Δ = {r:g}" for r in RATIOS).replace("inf", "∞") + " |"
    lines = [head, "|---|---|" + "---|" * len(RATIOS)]
    for delta in DELTAS:
        for name in TOLD:
            mine = table[(table["delta"] == delta) & (table["told"] == name)]
            cells = " | ".join(cell(mine[mine["ratio"] == r]) for r in RATIOS)
            lines.append(f"| {delta:g} | {name} | {cells} |")
    return "\n".join(lines)
