"""Newton's method on the contacts: from nearly at rest to equilibrium at round-off.

Contacts may open, close, stick and slide on the way (a semi-smooth Newton method, on the
tangent of ``dem.balance.tangent``).  Forces recomputed from rounded positions are off by ~ κ ε L,
that is ε L/Δ in units of p.  The last increments y therefore go to the forces in full, f + df(y),
and to the positions as far as these can hold them, x + y rounded once: the forces balance to
round-off, and f_n - κ overlap is a few κ ε L however soft the packing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dem.balance.contact_forces import ContactForces
from dem.balance.shift import Shift
from dem.balance.tangent import PIN, Equilibrium
from dem.balance.trial import Trial
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.state import State
from packing.arguments.arrays import Floats

ITERATIONS = 40
#: Newton steps without progress before it is taken as stalled; fewer at round-off.
PATIENCE, PATIENCE_AT_ROUND_OFF = 8, 2
#: A grain whose residual is above this, in p, is unbalanced.
UNBALANCED = 1e-6
#: Progress: the worst residual halves, or the number of unbalanced grains falls to this share.
FEWER = 0.7
#: A longer move (mean diameters) means that the tangent is singular: not near rest.  The moves of
#: long waves grow with the cell: in cells wider than so many diameters a move may be longer.
LONGEST_MOVE, WIDE = 0.2, 350.0
#: Largest f_n - κ overlap after the last moves, in κ ε L: more, and they were not linear.
LAG = 10
#: Refinements of the forces once positions can do no more, and times that contacts may be opened.
REFINEMENTS, OPENINGS = 20, 5


class PolishFailed(ArithmeticError):
    """Newton's method did not converge: the packing was not near enough to rest.

    ``relax`` integrates on and tries again; ``refine`` and ``stiffen`` end with it.
    ``iterations`` were made in vain.
    """

    def __init__(self, message: str, iterations: int = 0) -> None:
        super().__init__(message)
        self.iterations = iterations


def polish(
    state: State, near: Neighbours, law: ContactLaw, pressure: float, tolerance: float = 1e-9
) -> ContactForces:
    """Bring a packing in a cell to rest: `polished` at its equilibrium."""
    return polished(Equilibrium(state, near, law, pressure), state, tolerance)


def polished(
    balance: Equilibrium, state: State, tolerance: float = 1e-9, large: bool = False
) -> ContactForces:
    """Bring ``state`` (changed in place: positions, cell, history) to equilibrium.

    Raises PolishFailed when the tangent is singular or the residual stops falling above
    ``tolerance`` (in p) and round-off; the state is then as it was.  In ``large`` cells groups
    that are not balanced are held back (``dem.balance.shift``).
    """
    pressure = balance.pressure
    floor = _rounding_of_sums(balance)
    kept, iterations = newton(balance, floor, max(tolerance * pressure, 100 * floor), large)
    forces, y = _carry(balance, kept, pressure, iterations)
    balance.put(state, y, forces)
    return forces


def _rounding_of_sums(balance: Equilibrium) -> float:
    """A sum of forces κ δ, δ the difference of lengths of order 1, is good to ~ κ ε."""
    return float(10 * balance.stiffness * np.finfo(float).eps)


def newton(
    balance: Equilibrium, floor: float, good: float, large: bool = False
) -> tuple[Trial, int]:
    """The trial of the smallest residual, and the number of iterations.

    Ends at a residual of ``floor``, or when it stalls below ``good``; stalled above: PolishFailed.
    """
    pressure = balance.pressure
    longest = LONGEST_MOVE * max(1.0, float(balance.near.sides.max()) / WIDE)
    y = np.zeros(3 * balance.count + 1)
    trial = kept = balance.trial(y)
    best = lowest = fewest = np.inf
    stalled = iterations = 0
    shift = Shift(balance.count, large, good / pressure)
    while iterations < ITERATIONS:
        residual = trial.residual(trial.normal, trial.tangential)
        worst, grains = float(np.abs(residual).max()), _worst_of_grains(residual) / pressure
        unbalanced = int((grains > UNBALANCED).sum())
        if worst < 0.5 * best:
            best, kept = worst, trial
        if worst < 0.5 * lowest or unbalanced < FEWER * fewest:
            stalled = 0
        else:
            stalled += 1
        if iterations > 0:  # the first step lets contacts slip: it may well raise the residual
            lowest, fewest = min(worst, lowest), min(unbalanced, fewest)
        patience = PATIENCE if best > good else PATIENCE_AT_ROUND_OFF
        if worst <= floor or stalled > patience:
            break
        move = _newton_step(balance, trial, np.maximum(PIN, shift(trial, grains)))(residual)
        if not np.abs(move).max() < longest:  # also when it is NaN
            raise PolishFailed(f"a Newton step of {np.abs(move).max():.3g} ⟨σ⟩", iterations)
        y = y + move
        trial = balance.trial(y)
        iterations += 1
    if best > good:
        raise PolishFailed(f"the residual stays at {best / pressure:.3g} p", iterations)
    return kept, iterations


def _worst_of_grains(residual: Floats) -> Floats:
    """The largest component of the residual of every grain ``(N,)``."""
    return np.abs(residual[:-1]).reshape(3, -1).max(axis=0)


def _newton_step(
    balance: Equilibrium, trial: Trial, shift: Floats | float
) -> Callable[[Floats], Floats]:
    try:
        return balance.factorise(trial, shift)
    except RuntimeError as singular:  # how SuperLU puts a pivot of exactly zero
        raise PolishFailed(f"the tangent is singular ({singular})") from singular


def _carry(
    balance: Equilibrium, trial: Trial, pressure: float, iterations: int
) -> tuple[ContactForces, Floats]:
    """Forces after the last increments, f + df(y), and the moves that hold them.

    Contacts that would have to pull are opened, and the rest carried on without them. Elastic
    spheres that nothing presses never come to pull, since f_n ∝ δ^(3/2) has no slope at δ = 0:
    theirs are opened once they are below the rounding of the sums of forces.
    """
    faintest = _rounding_of_sums(balance) if balance.law.incremental else 0.0
    for _ in range(OPENINGS):
        normal, tangential, moves = increments(balance, trial)
        overlaps = balance.branches(moves)[1]
        lag = np.abs(normal - balance.law.force(overlaps))[trial.bearing].max(initial=0.0)
        if lag > LAG * balance.stiffness * np.finfo(float).eps * balance.near.sides.max():
            raise PolishFailed(f"f_n - κ overlap is {lag / pressure:.2g} p: moves too long")
        if balance.law.incremental and (turned := _turned_back(balance, trial, overlaps)):
            raise PolishFailed(f"{turned} contacts turn from loading to unloading, or back")
        pulls = trial.bearing & (normal < faintest)
        if not pulls.any():
            residual = np.abs(trial.residual(normal, tangential)).max()
            worst = float(residual) / pressure
            return ContactForces(normal, tangential, trial.bearing, worst, iterations), moves
        trial = balance.without(trial, pulls)
    raise PolishFailed(f"{int(pulls.sum())} contacts would have to pull")


def _turned_back(balance: Equilibrium, trial: Trial, overlaps: Floats) -> int:
    """Contacts that the last moves took to the other branch, by more than rounding."""
    one, other = trial.overlap - balance.overlap, overlaps - balance.overlap
    rounding = LAG * np.finfo(float).eps * balance.near.sides.max()
    turned = (one * other < 0) & (np.abs(one - other) > rounding)
    return int((turned & trial.bearing & ~trial.sliding).sum())


def increments(balance: Equilibrium, trial: Trial) -> tuple[Floats, Floats, Floats]:
    """Normal and tangential forces, refined on the tangent at ``trial``, and the moves."""
    response = balance.response(trial)
    normal, tangential = trial.normal, trial.tangential
    residual = trial.residual(normal, tangential)
    newton_step, moves = _newton_step(balance, trial, PIN), trial.y
    for _ in range(REFINEMENTS):
        y = newton_step(residual)
        stretched, slipped = trial.stretched(y), trial.slipped(y)
        new_normal = normal + response.normal * stretched
        new_tangential = tangential + response.slip * slipped + response.slide * stretched
        new_residual = trial.residual(new_normal, new_tangential)
        if np.abs(new_residual).max() >= np.abs(residual).max():
            break
        normal, tangential, residual, moves = new_normal, new_tangential, new_residual, moves + y
    return normal, tangential, moves
