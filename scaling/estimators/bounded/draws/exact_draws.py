"""Exact draws from the posterior of `bounded`: a Gaussian, balanced, cut off where f_n < 0 or
|f_t| > μ f_n.

On the null space of all equalities, in coordinates u in which the Gaussian is N(0, 1), the
density is exp(-u²/2) on the polytope F u + h >= 0. Hamilton's equations for it are solved in
closed form, u(t) = u cos t + v sin t between elastic bounces off the walls (Pakman and
Paninski, J. Comput. Graph. Stat. 23, 518 (2014)): trajectories of a quarter period from normal
velocities, no step size, nothing rejected. With F Fᵀ at hand a bounce costs as many operations
as there are walls. Dense: memory (4c)² numbers, for up to a few thousand grains.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky, qr, solve_triangular

from packing.arguments.arrays import Floats
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import flag, generator, instance, whole_number
from packing.progress import counted
from scaling.algebra.quadratic_program import minimise
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.bounded.program import Program, program_of

_MARGINS = 10.0 ** -np.arange(1.0, 8.0)
"""Distances from the walls, in f̄, at which a start is looked for."""
_RANK = 1e-10
_SEEN = 1e-9
"""Share of the largest response to u below which a wall counts as fixed."""
_THICKNESS = 1e-9
"""Of a wall, in standard deviations: what rounding may miss it by."""
_FRESH = 50
"""Bounces after which products are computed anew."""
_MOST_BOUNCES = 100_000


def truncated_draws(
    posterior: Posterior,
    rng: np.random.Generator,
    draws: int,
    *,
    burn_in: int = 20,
    progress: bool | None = None,
) -> Floats:
    """(draws, 2c) forces, successive states of the chain after `burn_in` trajectories.

    Directions turn linearly at the forces of the maximum. `progress`: None shows a bar on a
    terminal only, False never. ValueError: nothing is feasible, contacts that may be open (gaps
    have no Gaussian prior), less than one draw, burn_in negative, or other bad input.
    """
    instance("posterior", posterior, Posterior)
    generator("rng", rng)
    flights = whole_number("draws", draws, 1) + whole_number("burn_in", burn_in, 0)
    unknowns = posterior.equation.unknowns
    refuse_beyond(f"draws = {draws}, burn_in = {burn_in}", 8.0 * flights * unknowns)
    if progress is not None:
        flag("progress", progress)
    if posterior.gaps:
        raise ValueError("exact draws are for a Gaussian prior: gaps=True has another")
    forces, _, report = bounded_forces(posterior, progress)
    task = program_of(posterior, forces, curved=report.curved)
    centre, basis, u = _whitened(task, _interior(task))
    walls = Walls(-(task.cone @ basis), -(task.cone @ centre))
    found = []
    for k in counted(range(flights), flights, "exact draws", progress):
        u = walls.trajectory(u, rng.standard_normal(len(u)))
        if k >= burn_in:
            found.append(task.forces(centre + basis @ u))
    return np.array(found)


def _interior(task: Program) -> Floats:
    """The most probable z that keeps a margin to every wall, the largest of a ladder."""
    for margin in _MARGINS:
        try:
            z, report = minimise(task.P, task.q, task.equal, task.b, task.cone, -margin)
        except (ValueError, RuntimeError):
            continue
        if report["tolerance"] < margin / 2:
            return z
    raise ValueError(f"no state is off all walls by {_MARGINS[-1]:g} f̄")


def _whitened(task: Program, start: Floats) -> tuple[Floats, Floats, Floats]:
    """(centre, basis, u) with z = centre + basis u, N(0, 1) in u, and u of `start`."""
    N = _null_space(task)
    if N.shape[1] == 0:  # one state alone meets all conditions
        return start, N, np.zeros(0)
    L = cholesky(N.T @ (task.P[:, None] * N), lower=True)
    basis = solve_triangular(L, N.T, lower=True).T
    u = basis.T @ (task.P * start + task.q)  # the gradient is u where the Hessian is 1
    return start - basis @ u, basis, u


def _null_space(task: Program) -> Floats:
    """A basis of equal z = 0; the explicit f_n, the first c of z, are put in before."""
    explicit = np.arange(task.equal.shape[0])[task.explicit]
    c = len(explicit)
    inserted = task.equal[explicit][:, c:]
    implicit = np.delete(np.arange(task.equal.shape[0]), explicit)
    rest = task.equal[implicit]
    reduced = (rest[:, c:] - rest[:, :c] @ inserted).toarray()
    Q, R, _ = qr(reduced.T, mode="full", pivoting=True)
    diagonal = abs(np.diag(R))
    N = Q[:, int((diagonal > _RANK * diagonal[0]).sum()) :]
    return np.concatenate([-(inserted @ N), N])


class Walls:
    """The polytope F u + h >= 0 and the flight of a point in it."""

    def __init__(self, F: Floats, h: Floats) -> None:
        norm = np.linalg.norm(F, axis=1)
        met = norm > _SEEN * norm.max(initial=0.0)  # the others are as far as they are, whatever u
        self.F, self.h = F[met] / norm[met, None], h[met] / norm[met]
        self.gram = self.F @ self.F.T

    def trajectory(self, u: Floats, v: Floats) -> Floats:
        """Where a quarter period takes u, inside, with velocity v.

        A flight that rounding takes through a wall is given up, and u stays. RuntimeError: it
        bounces without end.
        """
        left, start = np.pi / 2, u
        for bounce in range(_MOST_BOUNCES):
            if bounce % _FRESH == 0:  # p and w drift in the updates below
                p, w = self.F @ u, self.F @ v
                if (p + self.h).min(initial=0.0) < -_THICKNESS:
                    return start
            wall, t = self._next(p, w)
            cos, sin = np.cos(min(t, left)), np.sin(min(t, left))
            u, v = cos * u + sin * v, cos * v - sin * u
            if t >= left:
                return u if (self.F @ u + self.h).min(initial=0.0) >= -_THICKNESS else start
            p, w = cos * p + sin * w, cos * w - sin * p
            push = 2 * float(self.F[wall] @ v)
            v, w = v - push * self.F[wall], w - push * self.gram[wall]
            left -= t
        raise RuntimeError(f"a flight between {len(self.h)} walls does not end")

    def _next(self, p: Floats, w: Floats) -> tuple[int, float]:
        """The first wall that p cos t + w sin t + h = 0 leaves through, and when."""
        amplitude = np.hypot(p, w)
        reached = np.flatnonzero(amplitude > abs(self.h))
        if len(reached) == 0:
            return 0, np.inf
        a, b = p[reached], w[reached]
        t = np.arctan2(b, a) + np.arccos(-self.h[reached] / amplitude[reached])
        t = np.mod(t, 2 * np.pi)
        t[(a + self.h[reached] < _THICKNESS) & (b < 0)] = 0.0  # at the wall, and leaving
        first = int(np.argmin(t))
        return int(reached[first]), float(t[first])
