"""Maximum a posteriori with what is certain about contacts: they push, and friction is limited.

    min  |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ]     over f, y

    subject to   M|f⟩ = -|F_ext⟩ ,    f_n >= 0 ,    |f_t| <= μ f_n ,    Σ f_n r = 2 p A ,
                 f_n = κ (σ̃ - r̃ - B y)                 data="all"
                 Q f_n = κ (Q|σ̃⟩ - Λ - Q B y)          data="sizes"

σ̃ and r̃ are the data, y is their noise of strength ξ, and B y its effect on the overlaps
(`scaling.noise.noise_model`). This is a convex quadratic program, solved by an interior-point
method: from 1000 contacts on, where the program has the form for it, by
`scaling.estimators.bounded.barrier`, else by clarabel.

Noisy positions turn directions, so M in the first condition is M(x̃) - D y, with D y the effect
of the noise on balance. The same y corrects directions and overlaps, and it is weighed. To
leave out what is quadratic in y makes forces wrong by ~ξ²/Δ. Near isostaticity, without
friction, that may leave nothing feasible; the second order is then let in as noise of its own.

The prior has the mean f̄ = 2 p A/Σ r, a = 1 and b = 1/2. For ξ << Δ the data decide. For ξ >>
Δ, what no datum sees stays at the mean of the prior, as near as balance, pressure and
inequalities allow. The error therefore saturates, where that of unbiased estimates grows as
ξ/Δ. It would also saturate without inequalities, at a higher level, and without a prior, since
inequalities leave a bounded set. A wrong friction or pressure costs most where the data are
good (docs/wrong_knowledge.md).

Where distances are no data, in data="sizes" and for ξ = ∞, the condition of the pressure needs
none: the forces across the sides of the cell state it (`scaling.estimators.bounded.program`).
Open networks need no p: since the loads are balanced, Σ f_n r = -Σ x·F holds instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance
from packing.progress import running
from scaling.algebra.quadratic_program import minimise
from scaling.estimators.bounded.barrier.interior_point import (
    FINE,
    ROUGH,
    Inside,
    by_interior_point,
)
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.bounded.program import Program, Shift, program_of

PASSES, GROWN, ROUNDING = 20, 1e-7, 1e-5
"""The most passes, the change of the mean force that ends them, and the one that may be left after
the last: some programs are solved to no more, and their forces are as good as that."""


@dataclass(frozen=True)
class Report:
    """Of the solver, `scaling.estimators.bounded.barrier` or `scaling.algebra.quadratic_program`;
    and whether the second order of distances was let in."""

    status: str
    iterations: int
    tolerance: float
    curved: bool
    solver: str = "clarabel"


class Maximum(NamedTuple):
    """Forces, η, the solver's report, and the program solved with its solution."""

    forces: Floats
    noise: Floats
    report: Report
    task: Program
    z: Floats


def bounded_forces(
    posterior: Posterior, progress: bool | None = None
) -> tuple[Floats, Floats, Report]:
    """(f, η, the solver's report) at the maximum of the posterior: see `bounded_maximum`."""
    found = bounded_maximum(posterior, progress)
    return found.forces, found.noise, found.report


def bounded_maximum(posterior: Posterior, progress: bool | None = None) -> Maximum:
    """The maximum of the posterior.

    Where noisy positions leave nothing feasible, the second order of the distances is let in as
    noise of its own (report: curved). ValueError: clarabel missing, or nothing feasible;
    RuntimeError: clarabel breaks down.
    """
    instance("posterior", posterior, Posterior)
    with running("bounded: most probable forces", progress):
        try:
            return passes(posterior, curved=False)
        except ValueError:
            if posterior.noise is None or not posterior.noise.moves:
                raise
        return passes(posterior, curved=True)


def passes(posterior: Posterior, curved: bool, shift: Shift | None = None) -> Maximum:
    """`bounded_maximum` with the second order of distances, or without.

    `shift` moves every Gaussian by noise of its own size: see
    `scaling.uncertainty.credible_intervals`.
    """
    f, noise = np.zeros(posterior.equation.unknowns), posterior.noise
    f[: posterior.equation.network.contacts] = posterior.mean_force
    # Directions turn, and forces grow, linearly at the forces of the last pass.
    least = 2 if (noise is not None and noise.moves) or (posterior.floats and shift) else 1
    inside = None
    for done in range(1, 1 + PASSES):
        task = program_of(posterior, f, shift, curved)
        z, report, inside = _minimum(task, inside, FINE if done >= least else ROUGH)
        f, growth = task.forces(z), float(task.growth(z))
        small = ROUNDING if done == PASSES else GROWN
        if done >= least and (shift is not None or abs(growth) <= small):
            return Maximum(f, task.noise(z), Report(**report, curved=curved), task, z)
        if shift is None and growth:
            posterior = replace(posterior, virial=posterior.virial * (1 + growth))
    raise RuntimeError(
        f"bounded: after {PASSES} passes the mean force still grows by {growth:.1e} of itself"
    )


def _minimum(
    task: Program, begin: Inside | None, gap: float
) -> tuple[Floats, dict, Inside | None]:
    """(z, report, the point inside) by the barrier, from `begin` to a `gap`; else by clarabel."""
    found = by_interior_point(task, begin, gap)
    if found is None:
        return *minimise(task.P, task.q, task.equal, task.b, task.cone), None
    report = {"status": "Solved", "iterations": found.rounds, "tolerance": found.tolerance}
    return found.z, {"solver": "barrier", **report}, found.inside
