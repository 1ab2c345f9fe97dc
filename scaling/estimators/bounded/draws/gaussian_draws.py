"""Draws from the posterior of `bounded` without its inequalities: exact ones of a Gaussian.

The forces balance and have the pressure that is told, but may pull, or exceed friction. Data,
prior mean and all else that is Gaussian are shifted by noise of their own size, and the least
squares with equalities, one linear system K whatever the shift, are solved again:

    [ P  Eᵀ ] (z ; λ) = ( -q ; b )
    [ E  0  ]

Why leave out what is certain? Within the inequalities the Gaussian has its mass away from their
edges, for there are many ways to be off them. Forces of packings are not: an eighth of the
contacts are near sliding, and P(f_n) does not vanish at 0, as the preparation left them. Draws
that are cut off there are sure of what is not so; draws that are not cut off cover the truth as
often as they say, and an *interval* may be cut off afterwards without any loss
(docs/intervals.md).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_array, csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu

from packing.arguments.arrays import Floats
from packing.progress import counted
from scaling.estimators.bounded.draws.shifts import shifts_of
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.bounded.program import Program, program_of

_SHIFT = 1e-10
"""Keeps redundant conditions apart; refined away."""
ACCURATE = 1e-6
"""What refinement may leave of the right-hand side: far less than draws scatter."""
_REFINEMENTS = 20


def gaussian_draws(
    posterior: Posterior, rng: np.random.Generator, draws: int, *, progress: bool | None = None
) -> Floats:
    """(draws, 2c) independent forces.

    Directions turn linearly at the forces of the maximum, and the second order of noisy distances
    is let in. `progress`: None shows a bar on a
    terminal only, False never. ValueError: bad input, nothing is feasible, or contacts that may be
    open (gaps have no Gaussian prior); RuntimeError: the system is too ill-conditioned.
    """
    shifts = shifts_of(posterior, rng, draws, progress, "Gaussian draws")
    forces = bounded_forces(posterior, progress)[0]
    curved = posterior.noise is not None and posterior.noise.moves
    solve = _Prepared(program_of(posterior, forces, curved=curved))
    found = []
    for shift in counted(shifts, draws, "Gaussian draws", progress):
        task = program_of(posterior, forces, shift, curved)
        found.append(task.forces(solve(task)))
    return np.array(found)


class _Prepared:
    """K, factorised once."""

    def __init__(self, task: Program) -> None:
        E = task.equal
        length = np.sqrt(np.asarray(E.multiply(E).sum(axis=1)).ravel())
        self.scale = 1 / np.where(length > 0, length, 1.0)
        self.E, n = csr_array(diags_array(self.scale) @ E), len(task.P)
        none = csr_array((E.shape[0], E.shape[0]))
        P = diags_array(task.P)
        self.K = csc_array(block_array([[P, self.E.T], [self.E, none]]))
        kept = self.K + diags_array(np.append(np.where(task.P == 0, _SHIFT, 0.0), none.diagonal()))
        kept = kept - block_array(
            [[csr_array((n, n)), None], [None, _SHIFT * eye_array(len(length))]]
        )
        self.lu, self.unknowns = splu(csc_array(kept)), n

    def __call__(self, task: Program) -> Floats:
        """Z of the program, whose E and P are those prepared."""
        right = np.append(-task.q, self.scale * task.b)
        found, size = np.zeros_like(right), float(abs(right).max())
        for _ in range(_REFINEMENTS):
            left = right - self.K @ found
            if abs(left).max() <= ACCURATE * size:
                return found[: self.unknowns]
            found += self.lu.solve(left)
        raise RuntimeError(
            f"Gaussian draws: {abs(left).max() / size:.1e} of the right-hand side is left, the "
            "conditions are too close to each other"
        )
