"""What a solver owes with its solution: an estimate, made afterwards, of how wrong it may be.

A linear system of condition κ, solved in doubles (ε = 2e-16) without loss, gives u to

    |δu|/|u|  ~  ε κ (1 + κ |ρ| / (|A| |u|)) ,      ρ the residual that least squares leave

and an iteration adds what it has not yet moved: with corrections that shrink by the factor q < 1,
the last of them d, at most  q/(1 - q) |d|.  A solution whose estimate exceeds `ACCEPTED` is not
returned but refused, with the number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats

EPS = float(np.finfo(float).eps)
ACCEPTED = 1e-5
"""Relative error of a solution up to which it is returned. The data of a packing are never known
better, and a matrix at the rank tolerance, of condition 1e10, still gives 4 ε κ = 9e-6."""
_SAFETY = 4.0


@dataclass(frozen=True, eq=False)
class Solved:
    """A solution, its estimated relative error, and the solver that found it.

    Attributes
    ----------
    values : (n,) or (n, k)
    error : |δu|/|u|, of the worst of the k columns
    solver : "dense", "factor", "lsmr", "clarabel", "barrier", or "none" if there
        was nothing to solve
    """

    values: Floats
    error: float
    solver: str


class NotAccurate(ValueError):
    """The equation has one solution, but this arithmetic does not determine it well enough."""


def rounding_error(condition: float, residual: Floats, size: float, values: Floats) -> float:
    """ε κ (1 + κ |ρ|/(|A| |u|)), of the worst column of `residual` (m, k) and `values` (n, k).

    `size` is |A|. Relative to the larger of |u| and |ρ|/|A|: a solution that vanishes beside the
    data, as transverse forces do by symmetry, is zero to rounding, not wrong.
    """
    lost = np.atleast_1d(np.linalg.norm(residual, axis=0))
    scale = np.maximum(size * np.atleast_1d(np.linalg.norm(values, axis=0)), lost)
    share = np.divide(lost, scale, out=np.zeros_like(lost), where=scale > 0)
    return _SAFETY * EPS * condition * (1 + condition * float(share.max(initial=0.0)))


def overlap_rounding(lengths: Floats, overlaps: Floats) -> float:
    """ε |σ|/|δ|: what the difference δ = σ - r of rounded `lengths` loses; 0 if none is left."""
    left = float(np.linalg.norm(overlaps))
    return _SAFETY * EPS * float(np.linalg.norm(lengths)) / left if left > 0 else 0.0


def accepted(solved: Solved, name: str, condition: float | None = None) -> Solved:
    """`solved` if its error is at most `ACCEPTED`; NotAccurate, naming the equation, if not."""
    if solved.error <= ACCEPTED:
        return solved
    why = "" if condition is None else f" has the condition {condition:.1e}, and"
    raise NotAccurate(
        f"{name}{why} is solved to a relative error of {solved.error:.1e} only (accepted "
        f"{ACCEPTED:g}); likely cause: directions as regular as a lattice's, or noise of very "
        "different strengths"
    )
