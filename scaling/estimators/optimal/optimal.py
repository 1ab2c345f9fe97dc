"""The best linear unbiased estimate from all geometric data, balance exact.

The noise that is most probable among those that leave a packing in equilibrium is taken out of the
data: see `scaling.estimators.optimal.least_noise`. Told all data and their covariance, it attains
the bound of `scaling.cramer_rao` to first order in the noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.estimator import LinearEstimator
from scaling.estimators.misfit import warn_if_implausible
from scaling.estimators.optimal.conditions import misfit_of_optimal
from scaling.estimators.optimal.least_noise import geometric_problem, optimal_forces, size_problem
from scaling.estimators.reconstruction import (
    Diagnostics,
    Reconstruction,
    reconstruction,
    unbalanced,
)
from scaling.estimators.response import Response
from scaling.noise.noise_model import noise_model
from scaling.noise.told_noise import check_told_noise, refuse_no_noise, told


@dataclass(frozen=True, eq=False)
class OptimalDiagnostics(Diagnostics):
    """What `Optimal` tells besides.

    Attributes
    ----------
    noise : numpy.ndarray
        (k,) the most probable η
    steps, change : int and float
        Of Gauss and Newton; of the forces in the last step, relative
    scale : float
        κ ξ: times `scaling.cramer_rao(...)` of the same arguments the error of the forces
    freedom : float
        The degrees of freedom of `misfit`
    """

    noise: Floats
    steps: int
    change: float
    scale: float
    freedom: float


@dataclass(frozen=True, eq=False)
class Optimal(LinearEstimator):
    """Generalised least squares, equilibrium exact.

    Parameters
    ----------
    xi, noise, covariance : float, str and array_like
        The noise of the data, see `scaling.noise.noise_model`; one of xi and
        covariance is needed to solve
    data : str
        "all", or "sizes" (no distances, directions exact)

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    `standard_errors` of what it finds are κ ξ times the rows of its error map. A noise found that
    is improbable for the strength told is an ImplausibleNoiseWarning.

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.503, 0.503], [(0, 1)], external=loads)
    >>> found = Optimal(xi=0.01).solve(force_equation(pair).with_law(10.0))
    >>> [f"{f:.3f}" for f in found.normal]
    ['1.000']
    """

    xi: float | None = None
    noise: str = "diameter"
    covariance: ArrayLike | None = None
    data: str = "all"

    name: ClassVar[str] = "optimal"

    def __post_init__(self) -> None:
        check_told_noise(self)

    def find(self, equation: ForceEquation) -> Reconstruction:
        """The least noise, and the forces without it."""
        refuse_no_noise(self)
        κ = self.stiffness(equation)
        model = noise_model(equation.network, self.noise, self.covariance, self.xi)
        solved, y, steps, change = optimal_forces(equation, κ, model, self.data)
        f, η = solved.values, y / model.xi
        misfit = misfit_of_optimal(equation, model, η, f / κ, self.data)
        warn_if_implausible(misfit, told(self))
        return reconstruction(
            self.name,
            equation,
            solved,
            unbalanced(equation, f),
            OptimalDiagnostics,
            misfit=misfit.value,
            response=self.response(equation, model, f / κ),
            noise=η,
            steps=steps,
            change=change,
            scale=κ * model.xi,
            freedom=misfit.most,
        )

    def prepared(self, at: Response) -> ConstrainedLeastSquares:
        """The problem in (y ; φ), with the noise of the response for weights."""
        if self.data == "sizes":
            return size_problem(at.equation, at.noise)
        return geometric_problem(at.equation, at.noise, at.φ)[0]

    def respond(self, at: Response, η: Floats) -> Solved:
        """( B (1 - P) ; T ) η , ( P ; T ) the constrained solve of C = M_n B + D."""
        equation, k, unit = at.equation, at.noise.count, at.noise.unit
        n, matrices, problem = equation.unknowns, equation.matrices, at.prepared
        if self.data == "sizes":
            QB = matrices.Q @ (at.overlaps @ η) / unit
            b = np.concatenate([np.zeros((equation.M.shape[0], *η.shape[1:])), QB])
            found = problem.solved(np.zeros_like(η), b)
            return Solved(unit * found.values[k : k + n], found.error, found.solver)
        B = equation.stiffened(at.overlaps)
        C: Any = matrices.M_normal @ B + at.balance
        found = problem.solved(np.zeros_like(η), C @ η / unit)
        u = found.values
        φ_t = unit * u[k : k + n - equation.network.contacts]
        return Solved(np.concatenate([B @ (η - u[:k]), φ_t]), found.error, found.solver)
