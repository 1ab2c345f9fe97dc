"""Transverse forces from equilibrium, given the normal ones:

    min |M_t f_t + F_ext + M_n f_n|² ,     M = [M_n, M_t]

That they are unique in disordered packings with Z < 6 makes the transverse force law redundant,
GPPSZ's claim (i).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import number_from_zero
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.estimator import LinearEstimator
from scaling.estimators.gppsz import check_solver
from scaling.estimators.plausibility import beyond_friction
from scaling.estimators.reconstruction import Diagnostics, Reconstruction, reconstruction
from scaling.estimators.response import Response


@dataclass(frozen=True, eq=False)
class TransverseDiagnostics(Diagnostics):
    """beyond_friction : how many contacts have |f_t| > μ f_n; None if friction is not told."""

    beyond_friction: int | None


@dataclass(frozen=True, eq=False)
class Transverse(LinearEstimator):
    """Directions and normal forces give the transverse forces; no size and no law enters.

    Parameters
    ----------
    normal_forces : array_like
        (c,), negative ones too; needed to solve, not for errors
    friction : float
        μ >= 0, with which the forces found are compared
    solver, tol : str
        See `Gppsz`

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    Sizes enter in torques alone, as lever arms. An error of the directions does enter.

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> loads = [[1.0, 0.1, 0.045], [-1.0, -0.1, 0.045]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.45, 0.45], [(0, 1)], external=loads)
    >>> found = Transverse([1.0]).solve(force_equation(pair))
    >>> [f"{f:.3f}" for f in found.tangential]
    ['-0.100']
    """

    normal_forces: ArrayLike | None = None
    friction: float | None = None
    solver: str = "auto"
    tol: float | None = None

    name: ClassVar[str] = "transverse"

    def __post_init__(self) -> None:
        check_solver(self.solver, self.tol)
        if self.friction is not None:
            number_from_zero("friction", self.friction)

    def uses_overlaps(self, equation: ForceEquation) -> bool:
        """Sizes are lever arms of torques, and nothing else."""
        return bool(equation.network.external[:, 2].any())

    def find(self, equation: ForceEquation) -> Reconstruction:
        """Equilibrium with the normal forces given."""
        refuse_unused_friction(equation, self.friction)
        self.check_kind(equation.frictional, winding=False)
        if self.normal_forces is None:
            raise ValueError("method 'transverse' needs normal_forces")
        shape = (equation.network.contacts,)
        fn = real_array("normal_forces", self.normal_forces, shape, "contact")
        return transverse_to(self, equation, fn)

    def prepared(self, at: Response) -> None:
        """Refuse what would leave no error at all, by mistake."""
        if at.noise.moves and at.lengths is None:
            raise ValueError("method 'transverse' feels position noise through δM f: give forces")

    def respond(self, at: Response, η: Floats) -> Solved:
        """( 0 ; -M_t⁺ D ) η."""
        return response_of_transverse(self, at, 0.0 * (at.overlaps @ η), η)

    def check_kind(self, frictional: bool, winding: bool) -> None:
        """It needs tangential forces to find."""
        super().check_kind(frictional, winding)
        if not frictional:
            raise ValueError(
                "method 'transverse' finds tangential forces: frictional=False has none"
            )


class FromNormal(Protocol):
    """An estimator that has normal forces first, and tangential ones from equilibrium."""

    @property
    def name(self) -> str:
        """As in the table of estimators."""

    @property
    def friction(self) -> float | None:
        """μ, with which the forces found are compared."""

    @property
    def solver(self) -> str:
        """See `Gppsz`."""

    @property
    def tol(self) -> float | None:
        """See `Gppsz`."""


def refuse_unused_friction(equation: ForceEquation, friction: float | None) -> None:
    """ValueError for a friction that is told where there is none."""
    if friction and not equation.frictional:
        raise ValueError(f"friction {float(friction)} is not used: frictional=False has none")


def transverse_to(asked: FromNormal, equation: ForceEquation, fn: Floats) -> Reconstruction:
    """Tangential forces from equilibrium, given the normal ones (negative ones too)."""
    matrices = equation.matrices
    b = equation.balance_rhs() - matrices.M_normal @ fn
    found = matrices.transverse.solved(b, asked.solver, asked.tol)
    residual, beyond = matrices.M_tangential @ found.values - b, None
    f = np.concatenate([fn, found.values])
    if asked.friction is not None:
        beyond = beyond_friction(equation, f, asked.friction)
    return reconstruction(
        asked.name,
        equation,
        Solved(f, found.error, found.solver),
        residual,
        TransverseDiagnostics,
        beyond_friction=beyond,
    )


def response_of_transverse(asked: FromNormal, at: Response, δ: Floats, η: Floats) -> Solved:
    """( δ ; -M_t⁺(D η + M_n δ) ) for errors δ of the normal forces, over κ ξ."""
    matrices = at.equation.matrices
    b = -(at.balance @ η) - matrices.M_normal @ δ
    found = matrices.transverse.solved(b, asked.solver, asked.tol)
    return Solved(np.concatenate([δ, found.values]), found.error, found.solver)
