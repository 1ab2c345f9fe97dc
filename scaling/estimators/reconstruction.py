"""Contact forces from a contact network, by six methods.

    gppsz       min |G f - ( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) )| over f      (sizes and directions)
    direct      f_n = κ (σ - r), then f_t from equilibrium          (sizes and distances)
    transverse  f_n given, f_t from equilibrium                     (directions, normal forces)
    balanced    min |Q f_n - κ (Q|σ⟩ - Λ)|, equilibrium exact       (see `balanced`)
    optimal     generalised least squares, equilibrium exact        (see `optimal`)
    bounded     as optimal, with f_n >= 0, |f_t| <= μ f_n, a prior   (see `bounded`)

f_t from equilibrium: min |M_t f_t + F_ext + M_n f_n|, with M = [M_n, M_t]. That it is unique in
disordered packings with Z < 6 makes the transverse force law redundant, GPPSZ's claim (i);
that `direct` needs the same precision as `gppsz` is the Comment's answer to claim (ii).

Refused, whatever the method: loads that no forces balance (`scaling.equation.loads`), and grains
that overlap by a good part of their size where overlaps become forces
(`scaling.estimators.plausibility`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, frozen, real_array
from packing.arguments.numbers import (
    choice,
    flag,
    instance,
    number_between,
    number_from_zero,
    positive_number,
    real_number,
)
from packing.immutable import Immutable
from scaling.algebra.evidence import NotAccurate, Solved, overlap_rounding
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.equation.loads import refuse_unbalanced
from scaling.equation.mechanisms import refuse_mechanisms
from scaling.estimators.balanced import balanced_forces
from scaling.estimators.bounded.bounded import bounded_maximum
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.misfit import misfit_of_bounded, misfit_of_optimal, warn_if_implausible
from scaling.estimators.optimal import optimal_forces
from scaling.estimators.plausibility import beyond_friction, refuse_deep_overlaps
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import NOISE
from scaling.noise.noise_model import sources

METHODS = ("gppsz", "direct", "transverse", "balanced", "optimal", "bounded")
SOLVERS = ("auto", "dense", "factor", "lsmr")


@dataclass(frozen=True, eq=False)
class Reconstruction(Immutable):
    """Forces found for a network.

    Attributes
    ----------
    normal, tangential : (c,) f_n and f_t (zeros if frictionless), in units of stiffness × length
    forces : (2c,) f_n then f_t; (c,) f_n alone if frictionless
    residual : root mean square over rows, a force; 0 for exact data. `gppsz`: of Eq. 1; `direct`,
        `transverse`: of equilibrium; `balanced`: of the loops; `optimal`, `bounded`: of
        equilibrium in the directions as measured. These two balance the grains in the directions
        that they find, so with noisy positions it does not vanish; else it is rounding
    method, solver : as used; solver "none" if no equation was solved
    diagnostics : rows, unknowns, hyperstaticity, and negative, the number with f_n < 0.
        `optimal` adds noise, the most probable η (k,), steps, change, of the forces in the
        last step, relative, and scale = κ ξ: times `scaling.cramer_rao(...)` of the same
        arguments it is the error of the forces.
        `bounded` adds noise, status, iterations and tolerance of the convex solver, and curved:
        whether the second order of distances had to be let in. Both add freedom, the degrees of
        freedom of misfit. `direct` and `transverse` add beyond_friction, the number with
        |f_t| > μ f_n, where friction was told
    imbalance : largest row of |M f + F_ext|, force or torque over radius, over the mean of |f_n|:
        by how much a grain fails to balance. Rounding for exact data; of order ξ/Δ with noise ξ
        for `gppsz` and `direct`, which do not insist on balance
    misfit : `optimal`, `bounded`: χ² per degree of freedom of the noise that had to be assumed,
        see `scaling.estimators.misfit`; None for other methods, for ξ = ∞ and where no condition
        is left over
    error_estimate : relative error of the forces that the solution of the equations leaves,
        a posteriori, apart from any error of the data; what σ - r loses if no equation was solved
    """

    normal: Floats
    tangential: Floats
    forces: Floats
    residual: float
    method: str
    solver: str
    diagnostics: Mapping[str, Any]
    imbalance: float
    misfit: float | None
    error_estimate: float


@dataclass(frozen=True, eq=False)
class _Question:
    """What `reconstruct` was asked, checked."""

    equation: ForceEquation
    method: str
    stiffness: float
    solver: str
    tol: float | None
    normal_forces: ArrayLike | None
    xi: float | None
    noise: str
    covariance: ArrayLike | None
    data: str
    friction: float | None
    pressure: float | None
    progress: bool | None


def reconstruct(
    network: ContactNetwork,
    stiffness: float | None,
    method: str = "gppsz",
    *,
    frictional: bool = True,
    solver: str = "auto",
    tol: float | None = None,
    normal_forces: ArrayLike | None = None,
    xi: float | None = None,
    noise: str = "diameter",
    covariance: ArrayLike | None = None,
    data: str = "all",
    friction: float | None = None,
    pressure: float | None = None,
    progress: bool | None = None,
) -> Reconstruction:
    """Find the contact forces of `network`; loads are those of `network.external`.

    Parameters
    ----------
    stiffness : κ > 0, force per length, f_n = κ (σ - r). `transverse` accepts None; a number
        has no bearing on its forces
    method : "gppsz", "direct", "transverse", "balanced", "optimal" or "bounded"
    frictional : False: no tangential forces, no torques
    solver, tol : see `scaling.algebra.least_squares`; tol for solver="lsmr" only
    normal_forces : (c,), for `transverse`
    xi, noise, covariance : for `optimal` and `bounded`, the noise of the data: see
        `scaling.noise.noise_model`; one of xi and covariance is needed. xi = inf, for `bounded`:
        sizes and distances are not known at all
    data : for `optimal` and `bounded`, "all" or "sizes" (no distances, directions exact)
    friction, pressure : for `bounded`: μ (not needed, and 0, if frictionless), and in a periodic
        cell p. `direct` and `transverse` compare their forces with μ, if it is told
    progress : for `bounded`: None shows a bar on a terminal only, False never

    ValueError: bad input, an argument that the method ignores, an equation without a unique
    solution, with its rank, loads that cannot be balanced, overlaps that are none, or conditions
    of `bounded` that contradict each other. RuntimeError: an iteration or the convex solver broke
    down. ImplausibleNoiseWarning: the noise found is improbable for the strength told;
    BeyondFrictionWarning: forces exceed the friction told.
    """
    instance("network", network, ContactNetwork)
    choice("method", method, METHODS)
    flag("frictional", frictional)
    _refuse_kinds(solver, tol, xi, noise, data, friction, pressure, progress)
    xi, friction, pressure = (None if v is None else float(v) for v in (xi, friction, pressure))
    unused = {
        "xi": xi is not None and method not in ("optimal", "bounded"),
        "noise": noise != "diameter" and method not in ("optimal", "bounded"),
        "covariance": covariance is not None and method not in ("optimal", "bounded"),
        "data": data != "all" and method not in ("optimal", "bounded"),
        "friction": friction is not None and method in ("gppsz", "balanced", "optimal"),
        "pressure": pressure is not None and method != "bounded",
        "normal_forces": normal_forces is not None and method != "transverse",
        "solver": solver != "auto" and method in ("balanced", "optimal", "bounded"),
        "tol": tol is not None and method in ("balanced", "optimal", "bounded"),
        "progress": progress is not None and method != "bounded",
    }
    for name, given in unused.items():
        if given:
            raise ValueError(f"method {method!r} does not use {name}")
    if friction and not frictional:
        raise ValueError(f"friction {friction} is not used: frictional=False has none")
    if method in ("optimal", "bounded") and xi is None and covariance is None:
        raise ValueError(f"method {method!r} needs the strength of the noise: xi, or covariance")
    if stiffness is None and method != "transverse":
        raise ValueError(f"method {method!r} needs the stiffness")
    κ = 1.0 if stiffness is None else positive_number("stiffness", stiffness)
    if _overlaps_matter(network, method, xi):
        refuse_deep_overlaps(network)
    equation = force_equation(network, frictional)
    refuse_unbalanced(equation)
    question = _Question(
        equation, method, κ, solver, tol, normal_forces, xi, noise, covariance, data, friction,
        pressure, progress,
    )  # fmt: skip
    try:
        found = _ANSWERS[method](question)
    except (RuntimeError, NotAccurate):
        refuse_mechanisms(equation)  # if that is why the solver broke down
        raise
    refuse_mechanisms(equation, found.forces)
    return found


def _refuse_kinds(
    solver: Any, tol: Any, xi: Any, noise: Any, data: Any, friction: Any, pressure: Any,
    progress: Any,
) -> None:  # fmt: skip
    choice("solver", solver, SOLVERS)
    choice("noise", noise, NOISE)
    choice("data", data, ("all", "sizes"))
    if tol is not None:
        number_between("tol", tol, 0, 1)
    if xi is not None:
        real_number("xi", xi)
    if friction is not None:
        number_from_zero("friction", friction)
    if pressure is not None:
        positive_number("pressure", pressure)
    if progress is not None:
        flag("progress", progress)


def _overlaps_matter(network: ContactNetwork, method: str, xi: float | None) -> bool:
    """Whether sizes enter the forces: `transverse` has them in torques only, ξ = ∞ nowhere."""
    if method == "transverse":
        return bool(network.external[:, 2].any())
    return xi is None or not np.isinf(xi)


def _gppsz(asked: _Question) -> Reconstruction:
    equation = asked.equation
    system, b = equation.matrices.system, equation.rhs(asked.stiffness)
    found = system.solved(b, asked.solver, asked.tol)
    return _result(asked, found, equation.G @ found.values - b)


def _balanced(asked: _Question) -> Reconstruction:
    return _result(asked, *balanced_forces(asked.equation, asked.stiffness))


def _optimal(asked: _Question) -> Reconstruction:
    equation, κ = asked.equation, asked.stiffness
    source = sources(equation.network, asked.noise, asked.covariance, asked.xi)
    solved, y, steps, change = optimal_forces(equation, κ, source, asked.data)
    f, η = solved.values, y / source.xi
    found = misfit_of_optimal(equation, source, η, f / κ, asked.data)
    warn_if_implausible(found, _told(asked))
    more = {"noise": η, "steps": steps, "change": change, "scale": κ * source.xi}
    more["freedom"] = found.most
    return _result(asked, solved, _unbalanced(equation, f), more, misfit=found.value)


def _bounded(asked: _Question) -> Reconstruction:
    equation, friction = asked.equation, asked.friction
    network, frictional = equation.network, equation.frictional
    if friction is None:
        if frictional:
            raise ValueError("method 'bounded' needs the friction coefficient")
        friction = 0.0
    xi, covariance = asked.xi, asked.covariance
    unknown = xi is not None and np.isinf(xi) and xi > 0 and covariance is None
    # Checked as for any ξ, though with ξ = ∞ nothing is left of the kind of noise.
    known = sources(network, asked.noise, covariance, None if unknown else xi)
    if asked.data == "sizes" and known.moves:
        raise ValueError("data='sizes' takes directions as exact: position noise needs data='all'")
    weak = None if unknown else known
    problem = posterior(
        network, asked.stiffness, friction, weak,
        pressure=asked.pressure, data=asked.data, frictional=frictional,
    )  # fmt: skip
    found = bounded_maximum(problem, asked.progress)
    more, value = {**found.report, "noise": found.noise}, None
    if not unknown:
        misfit = misfit_of_bounded(found.task, found.z)
        warn_if_implausible(misfit, _told(asked))
        more["freedom"], value = misfit.most, misfit.value
    # Of a convex programme the violation of its conditions is what is known afterwards.
    solved = Solved(found.forces, more["tolerance"], "clarabel")
    return _result(asked, solved, _unbalanced(equation, found.forces), more, misfit=value)


def _told(asked: _Question) -> str:
    return "covariance" if asked.covariance is not None else f"xi = {asked.xi:g}, {asked.noise}"


def _direct(asked: _Question) -> Reconstruction:
    network = asked.equation.network
    fn = asked.stiffness * network.overlaps
    if asked.equation.frictional:
        return _transverse_to(asked, fn)
    if asked.solver != "auto" or asked.tol is not None:
        raise ValueError("method 'direct' without friction solves nothing: no solver, tol")
    lengths = network.overlaps if network.extended is not None else network.sigma
    error = overlap_rounding(lengths, network.overlaps)
    return _result(asked, Solved(fn, error, "none"), _unbalanced(asked.equation, fn))


def _transverse(asked: _Question) -> Reconstruction:
    if not asked.equation.frictional:
        raise ValueError("method 'transverse' finds tangential forces: frictional=False has none")
    if asked.normal_forces is None:
        raise ValueError("method 'transverse' needs normal_forces")
    shape = (asked.equation.network.contacts,)
    return _transverse_to(
        asked, real_array("normal_forces", asked.normal_forces, shape, "contact")
    )


def _transverse_to(asked: _Question, fn: Floats) -> Reconstruction:
    """Tangential forces from equilibrium, given the normal ones (negative ones too)."""
    matrices = asked.equation.matrices
    b = asked.equation.balance_rhs() - matrices.M_normal @ fn
    found = matrices.transverse.solved(b, asked.solver, asked.tol)
    residual = matrices.M_tangential @ found.values - b
    f, more = np.concatenate([fn, found.values]), {}
    if asked.friction is not None:
        more["beyond_friction"] = beyond_friction(asked.equation, f, asked.friction)
    return _result(asked, Solved(f, found.error, found.solver), residual, more)


_ANSWERS: Mapping[str, Callable[[_Question], Reconstruction]] = {
    "gppsz": _gppsz,
    "direct": _direct,
    "transverse": _transverse,
    "balanced": _balanced,
    "optimal": _optimal,
    "bounded": _bounded,
}


def _unbalanced(equation: ForceEquation, forces: Floats) -> Floats:
    return equation.M @ forces - equation.balance_rhs()


def _imbalance(equation: ForceEquation, forces: Floats) -> float:
    """The largest row of |M f + F_ext| over ⟨|f_n|⟩, or the largest load if all f_n are 0."""
    largest = float(abs(_unbalanced(equation, forces)).max())
    mean = float(abs(forces[: equation.network.contacts]).mean())
    if largest == 0:
        return 0.0
    return largest / (mean or float(abs(equation.balance_rhs()).max()))


def _result(
    asked: _Question,
    solved: Solved,
    residual: Floats,
    more: Mapping[str, Any] | None = None,
    *,
    misfit: float | None = None,
) -> Reconstruction:
    equation, forces = asked.equation, solved.values
    c = equation.network.contacts
    normal = forces[:c]
    diagnostics = {
        "rows": len(residual),
        "unknowns": equation.unknowns,
        "hyperstaticity": equation.hyperstaticity,
        "negative": int((normal < 0).sum()),
        **(more or {}),
    }
    # A tree has no loops, and nothing is left over in none.
    rms = float(np.sqrt(np.mean(residual**2))) if len(residual) else 0.0
    return Reconstruction(
        frozen(normal),
        frozen(forces[c:] if equation.frictional else np.zeros(c)),
        frozen(forces),
        rms,
        asked.method,
        solved.solver,
        diagnostics,
        _imbalance(equation, forces),
        misfit,
        solved.error,
    )
