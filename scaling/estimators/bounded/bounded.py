"""The most probable forces of what is certain about contacts: they push, and friction is limited.

The posterior is in `scaling.estimators.bounded.maximum`, its prior in `Prior`. Intervals
that enclose the forces: `scaling.credible_intervals`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import (
    choice,
    flag,
    instance,
    number_from_zero,
    real_number,
    seed_number,
    shown,
    whole_number,
)
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.bounded.conditions import misfit_of_bounded
from scaling.estimators.bounded.diagnostics import Besides, BoundedDiagnostics
from scaling.estimators.bounded.draws.posterior_mean import BATCHES, posterior_mean
from scaling.estimators.bounded.maximum import Maximum, bounded_maximum
from scaling.estimators.bounded.posterior import Posterior, posterior_of
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.bounded.settling import Settled, settled
from scaling.estimators.estimator import Estimator
from scaling.estimators.misfit import Misfit, warn_if_implausible
from scaling.estimators.reconstruction import (
    Reconstruction,
    reconstruction,
    unbalanced,
)
from scaling.estimators.told.datum import Datum, Told, datum, is_unknown
from scaling.estimators.told.mean_stress import mean_stress
from scaling.estimators.told.strength import likely_strength
from scaling.estimators.transverse import refuse_unused_friction
from scaling.noise.noise_model import noise_model
from scaling.noise.told_noise import check_told_noise, refuse_no_noise, told


@dataclass(frozen=True, eq=False)
class Bounded(Estimator):
    """Maximum a posteriori with f_n >= 0, |f_t| <= μ f_n, balance exact, and a prior.

    Parameters
    ----------
    friction : float, (float, float) or str
        μ >= 0, the limit that no |f_t|/f_n exceeds; a value with its standard deviation, or
        "unknown", which find the limit from contacts that slide (twenty solves). Not needed, and
        0, where there are no tangential forces
    pressure : float, (float, float) or str
        p > 0, force per length, of a periodic cell; not used if open. Exact, with its standard
        deviation, or "unknown"
    stress : mapping, optional
        Components "xx", "xy", "yx", "yy" of the mean stress of a cell, compression positive, each
        exact or with its standard deviation
    loads : float or array_like, optional
        How the loads of the network err, as for `Optimal`; by default they are exact
    xi, noise, covariance : float, str and array_like
        The noise of the data, see `scaling.noise.noise_model`; one of xi and
        covariance is needed. xi = inf: sizes and distances are not known at all; xi =
        "unknown": of this kind, and of the strength that makes the misfit 1 (four solves)
    data : str
        "all", or "sizes" (no distances, directions exact)
    prior : Prior
        What forces are before anything is measured, a `Prior`
    gaps : bool
        Whether contacts of the list may be open, with data="all"
    closed : array_like, optional
        (c,) probabilities that contacts of the list bear a force at all, see
        `scaling.estimators.told.contacts`
    estimate : str
        "maximum" of the posterior, or its "mean", by draws (up to a few thousand grains)
    draws, seed : int
        Of the mean
    progress : bool
        None shows a bar on a terminal only, False never

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    min |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ] over forces and noise y, a convex
    quadratic program, solved by clarabel or, from 1000 contacts on, by a barrier method that knows
    where contacts lie. A noise found that is improbable for the strength told is an
    ImplausibleNoiseWarning. What is told as exact must be true: docs/wrong_knowledge.md.

    Examples
    --------
    >>> Bounded(friction=0.3, pressure=1e-3, xi=1e-3).prior
    Prior(mean=1.0, normal=1.0, tangential=0.5)
    """

    friction: Told | None = None
    pressure: Told | None = None
    stress: Mapping[str, Told] | None = None
    loads: ArrayLike | None = None
    xi: float | str | None = None
    noise: str = "diameter"
    covariance: ArrayLike | None = None
    data: str = "all"
    prior: Prior = Prior()  # noqa: RUF009  # frozen
    gaps: bool = False
    closed: ArrayLike | None = None
    estimate: str = "maximum"
    draws: int = 60
    seed: int = 0
    progress: bool | None = None

    name: ClassVar[str] = "bounded"

    def __post_init__(self) -> None:
        check_told_noise(self)
        if self.friction is not None:
            datum("friction", self.friction, number_from_zero)
        mean_stress(self.pressure, self.stress)
        instance("prior", self.prior, Prior)
        flag("gaps", self.gaps)
        choice("estimate", self.estimate, ("maximum", "mean"))
        whole_number("draws", self.draws, 2 * BATCHES)
        seed_number(self.seed)
        if self.progress is not None:
            flag("progress", self.progress)

    @property
    def blind(self) -> bool:
        """Whether neither sizes nor distances are known, ξ = ∞."""
        return self.xi == np.inf and self.covariance is None

    @property
    def decided(self) -> bool:
        """Whether ξ and μ are known exactly."""
        return not is_unknown(self.xi) and self._friction_exact

    @property
    def _friction_exact(self) -> bool:
        return self.friction is None or (self._told_friction or Datum(0.0, 1.0)).exact

    @property
    def _told_friction(self) -> Datum | None:
        """The value and error bar told; None if it is unknown, or not needed."""
        if self.friction is None:
            return None
        return datum("friction", self.friction, number_from_zero)

    def settle(self, equation: ForceEquation) -> tuple[Bounded, Settled]:
        """The same with what it does not know found, and what was found."""
        if self.decided:
            return self, Settled()

        if not self._friction_exact and not equation.frictional:
            raise ValueError(
                f"friction = {shown(self.friction)} is not used without tangential forces"
            )

        def solve(xi: float | None, friction: float | None) -> Maximum:
            return bounded_maximum(self._at(xi, friction).posterior(equation), False)

        start = likely_strength(equation, self.noise) if is_unknown(self.xi) else None
        found = settled(solve, start, self._told_friction, self._friction_exact)
        ξ = None if found.strength is None else found.strength.xi
        return self._at(ξ, None if found.friction is None else found.friction.value), found

    def _at(self, xi: float | None, friction: float | None) -> Bounded:
        """The same told these, where they are not None."""
        exact: dict[str, Any] = {"xi": xi, "friction": friction}
        if friction is None and isinstance(self.friction, tuple | list):
            exact["friction"] = self.friction[0]
        return replace(self, **{k: v for k, v in exact.items() if v is not None})

    def errs(self, equation: ForceEquation) -> bool:
        """Whether loads have error bars."""
        return self.loads is not None

    def refuse_free(self, equation: ForceEquation) -> None:
        """What no balance determines is as the prior has it."""

    def uses_overlaps(self, equation: ForceEquation) -> bool:
        """Nowhere for ξ = ∞."""
        return not self.blind

    def posterior(self, equation: ForceEquation) -> Posterior:
        """What is known of the forces of `equation`, before any solver is asked."""
        if not self.decided:
            return self.settle(equation)[0].posterior(equation)
        told_friction = self._told_friction
        μ = None if told_friction is None else told_friction.value
        refuse_unused_friction(equation, μ)
        refuse_no_noise(self)
        self.stiffness(equation)
        if self.friction is None and equation.frictional:
            raise ValueError("method 'bounded' needs the friction coefficient")
        model = noise_model(equation.network, self.noise, self.covariance, self._finite_xi)
        if self.data == "sizes" and model.moves:
            raise ValueError(
                "data='sizes' takes directions as exact: position noise needs data='all'"
            )
        return posterior_of(
            equation, μ, None if self.blind else model,
            pressure=self.pressure, stress=self.stress, data=self.data, prior=self.prior,
            gaps=self.gaps, loads=self.loads, closed=self.closed,
        )  # fmt: skip

    @property
    def _finite_xi(self) -> float | None:
        """ξ; checked as for any other, though with ξ = ∞ nothing is left of the kind of noise."""
        if self.blind or self.xi is None:
            return None
        return real_number("xi", self.xi)

    def find(self, equation: ForceEquation) -> Reconstruction:
        """The maximum of the posterior, and whether its noise is plausible."""
        made, unknowns = self.settle(equation)
        found = bounded_maximum(made.posterior(equation), self.progress)
        misfit = None if self.blind else misfit_of_bounded(found.task, found.z)
        if misfit is not None:
            warn_if_implausible(misfit, told(made))
        if self.loads is not None:
            equation = equation.with_balance(found.task.balance_rhs(found.z))
        forces, mean = found.forces, None
        if self.estimate == "mean":
            settled = found.task.posterior
            mean = posterior_mean(settled, self.seed, self.draws, self.progress)
            forces = mean.forces
        return self._recorded(equation, forces, found, misfit, Besides(unknowns, mean))

    def _recorded(
        self,
        equation: ForceEquation,
        forces: Floats,
        found: Maximum,
        misfit: Misfit | None,
        besides: Besides,
    ) -> Reconstruction:
        report = found.report
        return reconstruction(
            self.name,
            equation,
            # Of a convex program the violation of its conditions is what is known afterwards.
            Solved(forces, report.tolerance, report.solver),
            unbalanced(equation, forces),
            BoundedDiagnostics,
            misfit=None if misfit is None else misfit.value,
            noise=found.noise,
            status=report.status,
            iterations=report.iterations,
            tolerance=report.tolerance,
            curved=report.curved,
            freedom=None if misfit is None else misfit.most,
            settled=besides.settled,
            loads=equation.told_balance,
            mean=besides.mean,
        )
