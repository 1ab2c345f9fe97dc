"""What a packing at rest costs, as powers of N and Δ, and how far that may be trusted.

    cost = A N^a Δ^b,   cost = seconds of time steps, of Newton's method, or memory beyond PROGRAM,

fitted by least squares of the logarithms to the packings of 3000 grains on (smaller ones fit in
the caches) up to those of ``FITTED_UP_TO``; held against larger ones; and continued to sizes that
were never made.  The error of a prediction is that of one more packing: the scatter about the fit
and the error of the fit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats

FITTED_FROM, FITTED_UP_TO = 3000, 30_000
CONTINUED_TO = (10**7, 10**8)
#: MB of the program itself, of which no packing is the reason: 1000 grains take 2 MB more.
PROGRAM = 182.0
COSTS: dict[str, Callable[[np.ndarray], Floats]] = {
    "time steps, s": lambda t: t["motion"],
    "Newton's method, s": lambda t: t["polish"],
    "in all, s": lambda t: t["motion"] + t["polish"],
    "memory, MB": lambda t: t["MB"] - PROGRAM,
}


@dataclass(frozen=True)
class Model:
    """cost = exp(c₀) N^a Δ^b; ``coefficients`` (c₀, a, b), their covariance, the scatter."""

    coefficients: Floats
    covariance: Floats
    scatter: float

    @classmethod
    def fitted(cls, grains: Floats, delta: Floats, cost: Floats) -> Model:
        """To packings of at least two sizes and two Δ; ValueError to fewer than four."""
        if len(cost) < 4:
            raise ValueError(f"cost: {len(cost)} packings; a fit of three numbers needs four")
        x = _terms(grains, delta)
        found, _, rank, _ = np.linalg.lstsq(x, np.log(cost))
        if rank < 3:
            raise ValueError("grains, delta: one size or one Δ only, the exponents are not told")
        off = np.log(cost) - x @ found
        scatter = float(np.sqrt(off @ off / (len(cost) - 3)))
        return cls(found, scatter**2 * np.linalg.inv(x.T @ x), scatter)

    def predicted(self, grains: float, delta: float) -> tuple[float, float]:
        """The cost of one more packing, and the factor that is one standard error of it."""
        x = _terms(np.array([grains]), np.array([delta]))[0]
        error = np.sqrt(self.scatter**2 + x @ self.covariance @ x)
        return float(np.exp(x @ self.coefficients)), float(np.exp(error))

    def exponents(self) -> str:
        """N^(a ± error) Δ^(b ± error)."""
        (a, b), (u, v) = self.coefficients[1:], np.sqrt(np.diag(self.covariance))[1:]
        return f"N^({a:.2f} ± {u:.2f}) Δ^({b:.2f} ± {v:.2f})"


def _terms(grains: Floats, delta: Floats) -> Floats:
    return np.column_stack([np.ones(len(grains)), np.log(grains), np.log(delta)])


def models(table: np.ndarray) -> dict[str, Model]:
    """One of each cost."""
    fit = table[fitted_to(table)]
    return {
        name: Model.fitted(fit["grains"], fit["delta"], cost(fit)) for name, cost in COSTS.items()
    }


def fitted_to(table: np.ndarray) -> np.ndarray:
    """Which rows the models are fitted to."""
    return (table["grains"] >= FITTED_FROM) & (table["grains"] <= FITTED_UP_TO)


def text(table: np.ndarray) -> str:
    """The exponents; measured over predicted beyond the fit; what lies beyond any measurement."""
    fitted = models(table)
    lines = ["| cost | grows as | scatter of one packing |", "|---|---|---|"]
    for name, model in fitted.items():
        lines.append(f"| {name} | {model.exponents()} | × {np.exp(model.scatter):.2f} |")
    beyond = table[table["grains"] > FITTED_UP_TO]
    head = " | ".join(fitted)
    lines += ["", f"| measured over predicted: N | Δ | {head} |", "|---" * (len(fitted) + 2) + "|"]
    for row in beyond:
        cells = []
        for name, model in fitted.items():
            cost, factor = model.predicted(row["grains"], row["delta"])
            measured = COSTS[name](row)
            cells.append(f"{measured:.3g} over {cost:.3g} (×÷ {factor:.2f})")
        lines.append(f"| {row['grains']} | {row['delta']:.0e} | {' | '.join(cells)} |")
    lines += ["", f"| continued to N | Δ | {head} |", "|---" * (len(fitted) + 2) + "|"]
    for grains in CONTINUED_TO:
        for delta in np.unique(table["delta"])[::-1]:
            cells = [
                "{:.2g} (×÷ {:.2f})".format(*model.predicted(grains, delta))
                for model in fitted.values()
            ]
            lines.append(f"| {grains:.0e} | {delta:.0e} | {' | '.join(cells)} |")
    return "\n".join(lines).replace("e-0", "e-").replace("e+0", "e")
