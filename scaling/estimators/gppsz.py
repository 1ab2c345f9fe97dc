"""The estimate of Gendelman et al.: balance and closure alike in least squares,

    min |G f - ( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) )|²

from sizes and directions, without any distance. Of another law than f_n = κ δ closure is
Q|δ(f_n)⟩ = Q|σ⟩ - Λ, solved by Newton's method (`scaling.equation.nonlinear_closure`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import choice, number_between
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.equation.nonlinear_closure import solve_nonlinear
from scaling.estimators.estimator import SOLVERS, LinearEstimator
from scaling.estimators.reconstruction import Reconstruction, reconstruction
from scaling.estimators.response import Response


@dataclass(frozen=True)
class Gppsz(LinearEstimator):
    """Eq. 1 in unweighted least squares.

    Parameters
    ----------
    solver : str
        "auto", "dense", "factor" or "lsmr", see `scaling.algebra.least_squares`
    tol : float
        Relative tolerance of "lsmr", between 0 and 1

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    Eq. 1 of DeGiuli and McElwaine, PRL 116, 078001 (2016), after Gendelman et al., ibid. Noise ξ
    on sizes gives the error C ξ/Δ, see `scaling.amplification`.

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> found = Gppsz().solve(force_equation(pair).with_law(10.0))
    >>> [f"{f:.3f}" for f in found.normal]
    ['1.000']
    """

    solver: str = "auto"
    tol: float | None = None

    name: ClassVar[str] = "gppsz"
    closes_windings: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_solver(self.solver, self.tol)

    def find(self, equation: ForceEquation) -> Reconstruction:
        """Least squares with G; of a law that is not linear, by Newton's method."""
        law = self.law(equation)
        if not equation.linear:
            solved, residual = solve_nonlinear(equation, law, self.solver, self.tol)
            return reconstruction(self.name, equation, solved, residual)
        b = equation.rhs()
        solved = equation.matrices.system.solved(b, self.solver, self.tol)
        return reconstruction(self.name, equation, solved, equation.G @ solved.values - b)

    def respond(self, at: Response, η: Floats) -> Solved:
        """G⁺( -D ; Q B ) η."""
        matrices = at.equation.matrices
        b = np.concatenate([-(at.balance @ η), matrices.Q @ (at.overlaps @ η)])
        return matrices.system.solved(b, self.solver, self.tol)


def check_solver(solver: str, tol: float | None) -> None:
    """ValueError for an unknown solver, or a tolerance that is none."""
    choice("solver", solver, SOLVERS)
    if tol is not None:
        number_between("tol", tol, 0, 1)
