"""The most probable forces of what is certain about contacts: they push, and friction is limited.

The posterior is in `scaling.estimators.bounded.maximum`, its prior in `Prior`. Intervals
that enclose the forces: `scaling.credible_intervals`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import (
    flag,
    instance,
    number_from_zero,
    positive_number,
)
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.bounded.conditions import misfit_of_bounded
from scaling.estimators.bounded.maximum import Maximum, bounded_maximum
from scaling.estimators.bounded.posterior import Posterior, posterior_of
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.estimator import Estimator
from scaling.estimators.misfit import Misfit, warn_if_implausible
from scaling.estimators.reconstruction import (
    Diagnostics,
    Reconstruction,
    reconstruction,
    unbalanced,
)
from scaling.estimators.transverse import refuse_unused_friction
from scaling.noise.noise_model import noise_model
from scaling.noise.told_noise import check_told_noise, refuse_no_noise, told


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
    """

    noise: Floats
    status: str
    iterations: int
    tolerance: float
    curved: bool
    freedom: float | None


@dataclass(frozen=True, eq=False)
class Bounded(Estimator):
    """Maximum a posteriori with f_n >= 0, |f_t| <= μ f_n, balance exact, and a prior.

    Parameters
    ----------
    friction : float
        μ >= 0; not needed, and 0, where there are no tangential forces
    pressure : float
        p > 0, force per length, of a periodic cell; not used if open
    xi, noise, covariance : float, str and array_like
        The noise of the data, see `scaling.noise.noise_model`; one of xi and
        covariance is needed. xi = inf: sizes and distances are not known at all
    data : str
        "all", or "sizes" (no distances, directions exact)
    prior : Prior
        What forces are before anything is measured, a `Prior`
    gaps : bool
        Whether contacts of the list may be open, with data="all"
    progress : bool
        None shows a bar on a terminal only, False never

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    min |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ] over forces and noise y, a convex
    quadratic program, solved by clarabel. A noise found that is improbable for the strength told
    is an ImplausibleNoiseWarning. What is told must be true: docs/estimators.md.

    Examples
    --------
    >>> Bounded(friction=0.3, pressure=1e-3, xi=1e-3).prior
    Prior(mean=1.0, normal=1.0, tangential=0.5)
    """

    friction: float | None = None
    pressure: float | None = None
    xi: float | None = None
    noise: str = "diameter"
    covariance: ArrayLike | None = None
    data: str = "all"
    prior: Prior = Prior()  # noqa: RUF009  # frozen
    gaps: bool = False
    progress: bool | None = None

    name: ClassVar[str] = "bounded"

    def __post_init__(self) -> None:
        check_told_noise(self)
        if self.friction is not None:
            number_from_zero("friction", self.friction)
        if self.pressure is not None:
            positive_number("pressure", self.pressure)
        instance("prior", self.prior, Prior)
        flag("gaps", self.gaps)
        if self.progress is not None:
            flag("progress", self.progress)

    @property
    def blind(self) -> bool:
        """Whether neither sizes nor distances are known, ξ = ∞."""
        return self.xi is not None and self.xi == np.inf and self.covariance is None

    def uses_overlaps(self, equation: ForceEquation) -> bool:
        """Nowhere for ξ = ∞."""
        return not self.blind

    def posterior(self, equation: ForceEquation) -> Posterior:
        """What is known of the forces of `equation`, before any solver is asked."""
        refuse_unused_friction(equation, self.friction)
        refuse_no_noise(self)
        self.stiffness(equation)
        if self.friction is None and equation.frictional:
            raise ValueError("method 'bounded' needs the friction coefficient")
        # Checked as for any ξ, though with ξ = ∞ nothing is left of the kind of noise.
        xi = None if self.blind else self.xi
        model = noise_model(equation.network, self.noise, self.covariance, xi)
        if self.data == "sizes" and model.moves:
            raise ValueError(
                "data='sizes' takes directions as exact: position noise needs data='all'"
            )
        return posterior_of(
            equation, self.friction, None if self.blind else model,
            pressure=self.pressure, data=self.data, prior=self.prior, gaps=self.gaps,
        )  # fmt: skip

    def find(self, equation: ForceEquation) -> Reconstruction:
        """The maximum of the posterior, and whether its noise is plausible."""
        found = bounded_maximum(self.posterior(equation), self.progress)
        misfit = None if self.blind else misfit_of_bounded(found.task, found.z)
        if misfit is not None:
            warn_if_implausible(misfit, told(self))
        return self._recorded(equation, found, misfit)

    def _recorded(
        self, equation: ForceEquation, found: Maximum, misfit: Misfit | None
    ) -> Reconstruction:
        report = found.report
        return reconstruction(
            self.name,
            equation,
            # Of a convex program the violation of its conditions is what is known afterwards.
            Solved(found.forces, report.tolerance, "clarabel"),
            unbalanced(equation, found.forces),
            BoundedDiagnostics,
            misfit=None if misfit is None else misfit.value,
            noise=found.noise,
            status=report.status,
            iterations=report.iterations,
            tolerance=report.tolerance,
            curved=report.curved,
            freedom=None if misfit is None else misfit.most,
        )
