"""What an estimator returns: forces, what is left of its equations, and what it has to tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, frozen
from packing.arguments.immutable import Immutable
from scaling.algebra.estimate import Estimates
from scaling.algebra.evidence import Solved
from scaling.algebra.probes import Probing, probing
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.response import Response


@dataclass(frozen=True, eq=False)
class Diagnostics:
    """What every estimator tells; `diagnostics["negative"]` is `diagnostics.negative`.

    Attributes
    ----------
    rows, unknowns : int
        Of the equation that `residual` refers to
    hyperstaticity : int
        Unknowns minus independent balances, see `ForceEquation.hyperstaticity`
    negative : int
        The number of contacts with f_n < 0
    """

    rows: int
    unknowns: int
    hyperstaticity: int
    negative: int

    def __getitem__(self, name: str) -> Any:
        try:
            return getattr(self, name)
        except AttributeError:
            raise KeyError(name) from None


@dataclass(frozen=True, eq=False)
class Reconstruction(Immutable):
    """Forces found for a network.

    Parameters
    ----------
    normal, tangential : numpy.ndarray
        (c,) f_n and f_t (zeros if frictionless), in units of stiffness × length
    forces : numpy.ndarray
        (2c,) f_n then f_t; (c,) f_n alone if frictionless
    residual : float
        Root mean square over rows, a force; 0 for exact data. `gppsz`: of Eq. 1; `direct`,
        `transverse`: of equilibrium; `balanced`: of the loops; `optimal`, `bounded`: of
        equilibrium in the directions as measured. These two balance the grains in the directions
        that they find, so with noisy positions it does not vanish; else it is rounding
    method, solver : str
        As used; solver "none" if no equation was solved
    diagnostics : Diagnostics
        A record of the estimator's own: `Diagnostics`, or more, see each estimator
    imbalance : float
        Largest row of |M f + F_ext|, force or torque over radius, over the mean of |f_n|: by how
        much a grain fails to balance. Rounding for exact data; of order ξ/Δ with noise ξ for
        `gppsz` and `direct`, which do not insist on balance
    misfit : float
        `optimal`, `bounded`: χ² per degree of freedom of the noise that had to be assumed, see
        `scaling.estimators.misfit`; None for other methods, for ξ = ∞ and where no condition is
        left over
    error_estimate : float
        Relative error of the forces that the solution of the equations leaves, a posteriori,
        apart from any error of the data; what σ - r loses if no equation was solved
    response : Response
        Of estimators that were told the noise of the data and are linear in them: what that noise
        does to these forces; None for others

    Examples
    --------
    >>> from scaling import ContactNetwork, reconstruct
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> found = reconstruct(pair, 10.0)
    >>> found.method, found.diagnostics.unknowns, f"{found.imbalance:.3f}"
    ('gppsz', 2, '0.000')
    """

    normal: Floats
    tangential: Floats
    forces: Floats
    residual: float
    method: str
    solver: str
    diagnostics: Diagnostics
    imbalance: float
    misfit: float | None
    error_estimate: float
    response: Response | None = None

    @property
    def standard_errors(self) -> Floats:
        """(2c,) or (c,) standard deviations κ ξ |E_row| of the forces, of the noise told.

        E is the response at these forces; it is computed when asked for. They are the values of
        `estimated_errors()`, which says whether they are exact. ValueError: a method that is not
        told how noisy the data are, or not linear in them.
        """
        return self.estimated_errors().values

    def estimated_errors(self, probes: int | Probing | None = None) -> Estimates:
        """`standard_errors` with error bars of their own: exact ones, or from random probes.

        `probes`: see `gain`. Of 128 half of the standard errors are within 0.7 % (`gppsz`) to
        3.5 % (`optimal`); see `scaling.algebra.probes`.
        """
        if self.response is None:
            raise ValueError(
                f"method {self.method!r} has no standard errors: only an estimator that is linear "
                "and told the noise of the data has; see error_map for the errors per noise, and "
                "credible_intervals for those of 'bounded'"
            )
        scale = self.response.equation.stiffness * self.response.noise.xi
        return self.response.squares(probing(probes)).rows.root().scaled(scale)


def reconstruction(
    method: str,
    equation: ForceEquation,
    solved: Solved,
    residual: Floats,
    kind: type[Diagnostics] = Diagnostics,
    *,
    misfit: float | None = None,
    response: Response | None = None,
    **more: Any,
) -> Reconstruction:
    """The record of forces `solved` (n,), what they leave of the equations, and diagnostics of a
    `kind` with `more`."""
    forces, c = solved.values, equation.network.contacts
    normal = forces[:c]
    negative = int((normal < 0).sum())
    counts = len(residual), equation.unknowns, equation.hyperstaticity, negative
    # A tree has no loops, and nothing is left over in none.
    rms = float(np.sqrt(np.mean(residual**2))) if len(residual) else 0.0
    return Reconstruction(
        frozen(normal),
        frozen(forces[c:] if equation.frictional else np.zeros(c)),
        frozen(forces),
        rms,
        method,
        solved.solver,
        kind(*counts, **more),
        _imbalance(equation, forces),
        misfit,
        solved.error,
        response,
    )


def unbalanced(equation: ForceEquation, forces: Floats) -> Floats:
    """M f + F_ext, in the order of the rows of M."""
    return equation.M @ forces - equation.balance_rhs()


def _imbalance(equation: ForceEquation, forces: Floats) -> float:
    """The largest row of |M f + F_ext| over ⟨|f_n|⟩, or the largest load if all f_n are 0."""
    largest = float(abs(unbalanced(equation, forces)).max())
    mean = float(abs(forces[: equation.network.contacts]).mean())
    if largest == 0:
        return 0.0
    return largest / (mean or float(abs(equation.balance_rhs()).max()))
