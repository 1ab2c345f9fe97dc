"""Normal forces from overlaps, then transverse ones from equilibrium:

    f_n = κ (σ - r) ,     min |M_t f_t + F_ext + M_n f_n|²

σ is the sum of the radii and r the distance of the centres. Any contact law f_n = f(σ - r) will
do. That this needs the same precision as `gppsz` is the Comment's answer to GPPSZ's claim (ii).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from packing.arguments.arrays import Floats
from packing.arguments.numbers import number_from_zero
from scaling.algebra.evidence import Solved, overlap_rounding
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.estimator import LinearEstimator
from scaling.estimators.gppsz import check_solver
from scaling.estimators.reconstruction import Reconstruction, reconstruction, unbalanced
from scaling.estimators.response import Response
from scaling.estimators.transverse import (
    refuse_unused_friction,
    response_of_transverse,
    transverse_to,
)


@dataclass(frozen=True)
class Direct(LinearEstimator):
    """The contact law applied to the overlaps measured.

    Parameters
    ----------
    friction : float
        μ >= 0, with which the forces found are compared
    solver, tol : str
        Of the equilibrium, see `Gppsz`; without friction nothing is solved

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    `diagnostics.beyond_friction` is the number of contacts with |f_t| > μ f_n where friction is
    told.

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> found = Direct().solve(force_equation(pair).with_law(10.0))
    >>> [f"{f:.3f}" for f in found.normal]
    ['1.000']
    """

    friction: float | None = None
    solver: str = "auto"
    tol: float | None = None

    name: ClassVar[str] = "direct"

    def __post_init__(self) -> None:
        check_solver(self.solver, self.tol)
        if self.friction is not None:
            number_from_zero("friction", self.friction)

    def find(self, equation: ForceEquation) -> Reconstruction:
        """The law, then equilibrium."""
        refuse_unused_friction(equation, self.friction)
        network, δ = equation.network, equation.overlaps
        if network.free.any() and not equation.frictional:
            raise ValueError("free is not used: method 'direct' without friction asks no balance")
        fn = self.law(equation).force(δ)
        if equation.frictional:
            return transverse_to(self, equation, fn)
        if self.solver != "auto" or self.tol is not None:
            raise ValueError("method 'direct' without friction solves nothing: no solver, tol")
        error = overlap_rounding(δ if network.extended is not None else network.sigma, δ)
        solved = Solved(fn, error, "none")
        return reconstruction(self.name, equation, solved, unbalanced(equation, fn))

    def respond(self, at: Response, η: Floats) -> Solved:
        """( B ; -M_t⁺(D + M_n B) ) η, B times κ_e/κ̄."""
        δ = at.equation.stiffened(at.overlaps @ η)
        if not at.equation.frictional:
            return Solved(δ, 0.0, "none")
        return response_of_transverse(self, at, δ, η)
