"""The best linear unbiased estimate from all geometric data, balance exact.

The noise that is most probable among those that leave a packing in equilibrium is taken out of the
data: see `scaling.estimators.optimal.least_noise`. Told all data and their covariance, it attains
the bound of `scaling.cramer_rao` to first order in the noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import real_number
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.equation.mechanisms import refuse_mechanisms
from scaling.estimators.estimator import LinearEstimator
from scaling.estimators.misfit import Misfit, warn_if_implausible
from scaling.estimators.optimal.conditions import misfit_of_optimal
from scaling.estimators.optimal.least_noise import geometric_problem, optimal_forces, size_problem
from scaling.estimators.optimal.load_conditions import (
    load_columns,
    load_noise,
    row_scale,
    with_load_noise,
)
from scaling.estimators.optimal.stress_conditions import stress_conditions, with_stress_noise
from scaling.estimators.reconstruction import (
    Diagnostics,
    Reconstruction,
    reconstruction,
    unbalanced,
)
from scaling.estimators.response import Response
from scaling.estimators.told.datum import Told
from scaling.estimators.told.loads import load_errors
from scaling.estimators.told.mean_stress import MeanStress, mean_stress
from scaling.estimators.told.strength import Strength, likely_strength, strength
from scaling.noise.noise_model import NoiseModel, noise_model
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
    strength : Strength
        ξ with its standard error, where it was unknown; else None
    loads : numpy.ndarray
        (rows of M,) -|F_ext⟩ without the errors found, where loads have an error bar; else None
    """

    noise: Floats
    steps: int
    change: float
    scale: float
    freedom: float
    strength: Strength | None
    loads: Floats | None


@dataclass(frozen=True, eq=False)
class Optimal(LinearEstimator):
    """Generalised least squares, equilibrium exact.

    Parameters
    ----------
    xi, noise, covariance : float, str and array_like
        The noise of the data, see `scaling.noise.noise_model`; one of xi and
        covariance is needed to solve. xi = "unknown": of this kind, and of the strength that
        makes the misfit 1
    data : str
        "all", or "sizes" (no distances, directions exact)
    stress : mapping, optional
        What is known of the mean stress of a cell, compression positive: "p", the pressure, and
        the components "xx", "xy", "yx", "yy", each a number, or a number with its standard
        deviation. Error maps take exact ones only
    loads : float or array_like, optional
        How the loads of the network err, for data="all" and "sizes": a standard deviation of each
        force on grains that bear one (times R of torques), (N, 3) of them for F_x, F_y and T, or
        3N variances or a covariance, see `scaling.estimators.told.loads`; exact by default

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

    xi: float | str | None = None
    noise: str = "diameter"
    covariance: ArrayLike | None = None
    data: str = "all"
    stress: Mapping[str, Told] | None = None
    loads: ArrayLike | None = None

    name: ClassVar[str] = "optimal"

    def __post_init__(self) -> None:
        check_told_noise(self)
        mean_stress(None, self.stress)

    def errs(self, equation: ForceEquation) -> bool:
        """Whether loads have error bars."""
        return self.loads is not None

    @property
    def told(self) -> MeanStress:
        """What is known of the mean stress."""
        return mean_stress(None, self.stress)

    def find(self, equation: ForceEquation) -> Reconstruction:
        """The least noise, and the forces without it."""
        refuse_no_noise(self)
        made, found = self, None
        if isinstance(self.xi, str):
            start = likely_strength(equation, self.noise)
            found = strength(lambda ξ: replace(self, xi=ξ).least_noise(equation)[2], start)
            made = replace(self, xi=found.xi)
        κ = self.stiffness(equation)
        (solved, y, steps, change), model, misfit = made.least_noise(equation)
        f, η = solved.values, y / model.xi
        warn_if_implausible(misfit, told(made))
        if model.loads is not None:
            rhs = equation.balance_rhs() + model.loads @ load_noise(model, y)
            equation = equation.with_balance(rhs)
            refuse_mechanisms(equation, f)
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
            strength=found,
            loads=equation.told_balance,
        )

    def least_noise(
        self, equation: ForceEquation
    ) -> tuple[tuple[Solved, Floats, int, float], NoiseModel, Misfit]:
        """What `optimal_forces` finds, the noise model, and the misfit."""
        κ = self.stiffness(equation)
        ξ = None if self.xi is None else real_number("xi", self.xi)
        plain = noise_model(equation.network, self.noise, self.covariance, ξ)
        plain = with_load_noise(equation, plain, load_errors(equation, self.loads))
        model = with_stress_noise(plain, self.told)
        found = optimal_forces(equation, κ, model, self.data, self.told)
        η = found[1] / model.xi
        return found, model, misfit_of_optimal(equation, model, η, found[0].values / κ, self)

    def prepared(self, at: Response) -> ConstrainedLeastSquares:
        """The problem in (y ; φ), with the noise of the response for weights."""
        if self.loads is not None and at.noise.loads is None:
            raise ValueError(
                "errors are per noise of the geometry: loads with error bars of their own have "
                "none; ask what `reconstruct` returns for standard_errors()"
            )
        if self.data == "sizes":
            return size_problem(at.equation, at.noise, self.told)
        return geometric_problem(at.equation, at.noise, at.φ, self.told)[0]

    def respond(self, at: Response, η: Floats) -> Solved:
        """( B (1 - P) ; T ) η , ( P ; T ) the constrained solve of C = M_n B + D."""
        equation, k, unit = at.equation, at.noise.count, at.noise.unit
        n, matrices, problem = equation.unknowns, equation.matrices, at.prepared
        stress = stress_conditions(equation, at.noise, self.told)
        of_loads = load_columns(equation, at.noise)
        scaled = row_scale(of_loads, unit)
        if self.data == "sizes":
            QB = matrices.Q @ (at.overlaps @ η) / unit
            b = np.concatenate([-(scaled @ (of_loads @ η)) / unit, QB, stress.errors @ η / unit])
            found = problem.solved(np.zeros_like(η), b)
            return Solved(unit * found.values[k : k + n], found.error, found.solver)
        B = equation.stiffened(at.overlaps)
        C: Any = matrices.M_normal @ B + at.balance + of_loads
        b = np.concatenate([scaled @ (C @ η), stress.of_noise(B) @ η]) / unit
        found = problem.solved(np.zeros_like(η), b)
        u = found.values
        φ_t = unit * u[k : k + n - equation.network.contacts]
        return Solved(np.concatenate([B @ (η - u[:k]), φ_t]), found.error, found.solver)
