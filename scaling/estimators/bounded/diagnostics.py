"""What `bounded` tells besides the forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from packing.arguments.arrays import Floats
from scaling.estimators.bounded.draws.posterior_mean import PosteriorMean
from scaling.estimators.bounded.settling import Settled
from scaling.estimators.reconstruction import Diagnostics


@dataclass(frozen=True, eq=False)
class BoundedDiagnostics(Diagnostics):
    """What `Bounded` tells besides.

    Attributes
    ----------
    noise : numpy.ndarray
        (k,) the most probable η
    status, iterations, tolerance : str, int and float
        Of the convex solver, see `scaling.algebra.quadratic_program`
    curved : bool
        Whether the second order of distances had to be let in
    freedom : float
        The degrees of freedom of `misfit`; None for ξ = ∞
    settled : Settled
        What was found of ξ and μ where they were not told exactly, with error bars and the
        profile over μ
    mean : PosteriorMean
        Of `estimate="mean"`, with the error that the number of draws leaves; else None
    loads : numpy.ndarray
        (rows of M,) -|F_ext⟩ without the errors found, where loads have an error bar; else None
    """

    noise: Floats
    status: str
    iterations: int
    tolerance: float
    curved: bool
    freedom: float | None
    settled: Settled
    mean: PosteriorMean | None
    loads: Floats | None


class Besides(NamedTuple):
    """What was found besides the forces."""

    settled: Settled
    mean: PosteriorMean | None
