"""The most probable forces by an interior-point method on a system of 5 unknowns a grain:

    r(z) + s = 0 ,    ν_i s_i = τ ,    s, ν > 0 ,    τ -> 0

r are the limits of friction, ν their multipliers, s slacks. Newton's step is a linear system with
the weights ν/s on the limits (`scaling.estimators.bounded.barrier.condensed`); balance and data
hold in each. Mehrotra's predictor says how far τ can fall, his corrector what is of second order
(SIAM J. Optim. 2, 575, 1992). At the end the conditions of Karush, Kuhn and Tucker are checked on
the program itself, of which, as it is convex, they prove the minimum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats
from scaling.estimators.bounded.barrier.condensed import ROUNDS, Blocks, Condensed, Point
from scaling.estimators.bounded.order import Sites, sites_of
from scaling.estimators.bounded.program import NO_LIMIT, WEAK, Program

FROM = 1000
"""Contacts from which this is faster than a solver for any program."""
ROUGH, FINE = 1e-4, 3e-10
"""τ at the end of a pass after which directions turn once more, and of the last. Of the first
nothing is kept but its forces, for that."""
_ROUNDS = 50
_BORDERS = 16
"""The most conditions and unknowns that meet all others."""
_SOLVED = 1e-8
"""What may be left of the conditions: as for the other solver."""
_SLACK, _BEGIN = 0.03, 3.0
"""The least slack to begin with, and ν s there: with less the first steps are short."""
_STIFFEST, _CORRECTIONS, _RELEASES = 1e8, 3, 4
"""The largest weight of a limit in the last step, solves of that, and repetitions of it."""
FAINT = np.array([[2e-12], [1e-12]])
"""Weights of limits that are not felt: not 0, so that no entry of the matrix is."""
_NEAR_THE_EDGE = 0.995
"""Share of the way to where a slack or a multiplier would vanish."""


@dataclass(frozen=True, eq=False)
class Inside:
    """A point with slacks and multipliers (2, c), both positive."""

    at: Point
    s: Floats
    ν: Floats

    @property
    def gap(self) -> float:
        """τ, the mean of ν s."""
        return float(np.mean(self.s * self.ν))

    def moved(self, aim: Point, ds: Floats, dν: Floats, share: float) -> Inside:
        """So far on a way."""
        return Inside(self.at.towards(aim, share), self.s + share * ds, self.ν + share * dν)


@dataclass(frozen=True, eq=False)
class Found:
    """z of the program, where it was found, the rounds, and the largest violation."""

    z: Floats
    inside: Inside
    rounds: int
    tolerance: float


def by_interior_point(
    task: Program, begin: Inside | None = None, gap: float = FINE
) -> Found | None:
    """The minimum of the program to a `gap`; None where this does not find it.

    `begin`: of a program that differs in the turning of directions only.
    """
    prepared = prepared_for(task)
    if prepared is None:
        return None
    blocks, sites = prepared
    μ, here, made = task.posterior.friction, begin, None
    try:
        for done in range(_ROUNDS):
            if here is not None and here.gap <= gap:
                end = here if gap > FINE else _settled(blocks, sites, here, μ, made)
                tolerance = violation(blocks, end, μ)
                good = tolerance <= _SOLVED or gap > FINE
                return Found(end.at.z, here, done, tolerance) if good else None
            weights = FAINT * np.ones(blocks.contacts) if here is None else here.ν / here.s
            made = Condensed(blocks, sites, weights, μ, made)
            here = _begun(made) if here is None else _step(made, here)
            if not np.isfinite(here.gap):
                return None
    except (RuntimeError, np.linalg.LinAlgError):
        return None
    return None


def prepared_for(task: Program) -> tuple[Blocks, Sites] | None:
    """The blocks of a program and where its unknowns lie; None if it is small, or has not the
    form: friction, noisy distances, a known mean force, all contacts closed."""
    p = task.posterior
    if (
        not p.equation.frictional
        or p.equation.network.contacts < FROM
        or not WEAK <= p.friction < NO_LIMIT
        or task.explicit.start == task.explicit.stop
        or task.growing is not None
        or len(task.b) - task.explicit.stop + len(task.P) - task.unknowns - task.sources > _BORDERS
    ):
        return None
    blocks, sites = Blocks(task), sites_of(p)
    return None if blocks.beside or sites is None else (blocks, sites)


def _begun(made: Condensed) -> Inside:
    """The forces that no limit holds, with slack at each."""
    at = made.point(np.zeros((2, made.blocks.contacts)))
    s = np.maximum(-at.beyond(made.μ), _SLACK)
    return Inside(at, s, _BEGIN / s)


def _step(made: Condensed, here: Inside) -> Inside:
    s, ν = here.s, here.ν

    def aimed(target: Floats | float, rounds: int) -> tuple[Point, Floats, Floats]:
        """The aim, and the ways of s and ν, where ν s + their changes = target."""
        aim = made.point(target / s + ν, rounds)
        ds = -aim.beyond(made.μ) - s
        return aim, ds, (target - ν * s - ν * ds) / s

    _, ds, dν = aimed(0.0, 0)
    share = min(_longest(s, ds), _longest(ν, dν))
    ahead = float(np.mean((s + share * ds) * (ν + share * dν)))
    τ = here.gap * (ahead / here.gap) ** 3
    aim, ds, dν = aimed(τ - ds * dν, ROUNDS)
    share = min(1.0, _NEAR_THE_EDGE * min(_longest(s, ds, np.inf), _longest(ν, dν, np.inf)))
    return here.moved(aim, ds, dν, share)


def _settled(
    blocks: Blocks, sites: Sites, here: Inside, μ: float, made: Condensed | None
) -> Inside:
    """One step more. A slack near rounding tells no digit of its multiplier: this one is found
    from weights that are not too large, and corrected by what is left of the slack. A limit whose
    multiplier comes out negative does not hold."""
    weights = here.ν / here.s
    hard = weights > _STIFFEST
    weights = np.where(hard, _STIFFEST, weights)
    begin = here.ν - weights * here.at.beyond(μ)
    for _ in range(_RELEASES):
        made = Condensed(blocks, sites, weights, μ, made)
        ν, at = begin, here.at
        for _ in range(_CORRECTIONS):
            ν = np.where(hard, ν + weights * at.beyond(μ), ν)
            at = made.point(ν)
        found = ν + weights * at.beyond(μ)
        wrong = hard & (found < 0)
        if not wrong.any():
            break
        weights, begin = np.where(wrong, 0.0, weights), np.where(wrong, 0.0, begin)
        hard = hard & ~wrong
    return Inside(at, here.s, found)


def _longest(x: Floats, dx: Floats, most: float = 1.0) -> float:
    """The share of the way dx on which x stays positive."""
    falling = dx < 0
    return min(most, float((-x[falling] / dx[falling]).min(initial=most)))


def violation(B: Blocks, here: Inside, μ: float) -> float:
    """Of the conditions of the program and of those of Karush, Kuhn and Tucker, the largest.

    Stationarity relative to the largest multiplier, Σ ν s to the cost.
    """
    task, c, at, z, ν = B.task, B.contacts, here.at, here.at.z, here.ν
    y_n = B.P[:c] * at.φ_n + B.q[:c] + B.M_n.T @ at.λ + B.R_n.T @ at.τ
    y_t = B.P[c : 2 * c] * at.φ_t + B.q[c : 2 * c] + B.M_t.T @ at.λ + B.R_t.T @ at.τ
    θ = μ * ν.sum(axis=0) - y_n  # the multipliers of the data
    noise = B.P[B.noise] * at.v + B.X.T @ θ + B.T.T @ at.λ + B.R_v.T @ at.τ
    rest = B.P[B.noise.stop :] * at.w + B.q[B.noise.stop :] + B.V.T @ at.λ + B.R_w.T @ at.τ
    size = max(1.0, *(float(abs(m).max(initial=0.0)) for m in (at.λ, θ, ν)))
    left = [abs(task.equal @ z - task.b), np.maximum(task.cone @ z, 0.0)]
    stationary = (np.maximum(-ν, 0.0).ravel(), abs(y_t + ν[0] - ν[1]), abs(noise), abs(rest))
    left += [some / size for some in stationary]
    cost = abs(z @ (task.P * z) / 2 + task.q @ z)
    left.append(np.array([abs((ν * at.beyond(μ)).sum()) / max(1.0, cost)]))
    return float(max(some.max(initial=0.0) for some in left))
