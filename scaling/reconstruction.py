"""Contact forces from a contact network, by six methods.

    gppsz       min |G f - ( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) )| over f      (sizes and directions)
    direct      f_n = κ (σ - r), then f_t from equilibrium          (sizes and distances)
    transverse  f_n given, f_t from equilibrium                     (directions, normal forces)
    balanced    min |Q f_n - κ (Q|σ⟩ - Λ)|, equilibrium exact       (see `scaling.balanced`)
    optimal     generalised least squares, equilibrium exact        (see `scaling.optimal`)
    bounded     as optimal, with f_n >= 0, |f_t| <= μ f_n, a prior   (see `scaling.bounded`)

f_t from equilibrium: min |M_t f_t + F_ext + M_n f_n|, with M = [M_n, M_t]. That it is unique in
disordered packings with Z < 6 makes the transverse force law redundant, GPPSZ's claim (i);
that `direct` needs the same precision as `gppsz` is the Comment's answer to claim (ii).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arrays import Floats, frozen, real_array
from packing.immutable import Immutable
from scaling.balanced import balanced_forces
from scaling.bounded import bounded_forces
from scaling.equation import ForceEquation, force_equation
from scaling.optimal import optimal_forces
from scaling.posterior import posterior
from scaling.sources import sources

if TYPE_CHECKING:
    from scaling.network import ContactNetwork

METHODS = ("gppsz", "direct", "transverse", "balanced", "optimal", "bounded")


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
        whether the second order of distances had to be let in
    """

    normal: Floats
    tangential: Floats
    forces: Floats
    residual: float
    method: str
    solver: str
    diagnostics: Mapping[str, Any]


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
) -> Reconstruction:
    """Find the contact forces of `network`; loads are those of `network.external`.

    Parameters
    ----------
    stiffness : κ > 0, force per length, f_n = κ (σ - r). `transverse` accepts None; a number
        has no bearing on its forces
    method : "gppsz", "direct", "transverse", "balanced", "optimal" or "bounded"
    frictional : False: no tangential forces, no torques
    solver, tol : see `scaling.least_squares`; tol for solver="lsmr" only
    normal_forces : (c,), for `transverse`
    xi, noise, covariance : for `optimal` and `bounded`, the noise of the data: see
        `scaling.sources`; one of xi and covariance is needed. xi = inf, for `bounded`: sizes and
        distances are not known at all
    data : for `optimal` and `bounded`, "all" or "sizes" (no distances, directions exact)
    friction, pressure : for `bounded`: μ (not needed, and 0, if frictionless), and in a periodic
        cell p

    ValueError: bad input, an argument that the method ignores, an equation without a unique
    solution, with its rank, or conditions of `bounded` that contradict each other. RuntimeError:
    an iteration or the convex solver broke down.
    """
    if method not in METHODS:
        raise ValueError(f"method {method!r} is unknown; there are {', '.join(METHODS)}")
    weighs, equation_only = method in ("optimal", "bounded"), method in ("gppsz", "direct")
    given = {
        "xi": xi is not None and not weighs,
        "noise": noise != "diameter" and not weighs,
        "covariance": covariance is not None and not weighs,
        "data": data != "all" and not weighs,
        "friction": friction is not None and method != "bounded",
        "pressure": pressure is not None and method != "bounded",
        "normal_forces": normal_forces is not None and method != "transverse",
        "solver": solver != "auto" and not (equation_only or method == "transverse"),
        "tol": tol is not None and not (equation_only or method == "transverse"),
    }
    for name, is_given in given.items():
        if is_given:
            raise ValueError(f"method {method!r} does not use {name}")
    if weighs and xi is None and covariance is None:
        raise ValueError(f"method {method!r} needs the strength of the noise: xi, or covariance")
    if data not in ("all", "sizes"):
        raise ValueError(f"data {data!r}: choose 'all' or 'sizes'")
    if stiffness is None:
        if method != "transverse":
            raise ValueError(f"method {method!r} needs the stiffness")
        stiffness = 1.0  # no bearing on forces from equilibrium
    elif not (np.isfinite(stiffness) and stiffness > 0):
        raise ValueError(f"stiffness {stiffness}: it must be positive")
    equation = force_equation(network, frictional)
    if method == "gppsz":
        return _gppsz(equation, stiffness, solver, tol)
    if method == "balanced":
        found, residual = balanced_forces(equation, stiffness)
        return _result(equation, found.values, residual, method, found.solver)
    if method == "optimal":
        source = sources(network, noise, covariance, xi)
        found, y, steps, change = optimal_forces(equation, stiffness, source, data)
        f = found.values
        more = {"noise": y / source.xi, "steps": steps, "change": change}
        more["scale"] = stiffness * source.xi
        return _result(equation, f, _imbalance(equation, f), method, found.solver, more)
    if method == "bounded":
        if friction is None:
            if frictional:
                raise ValueError("method 'bounded' needs the friction coefficient")
            friction = 0.0
        elif friction and not frictional:
            raise ValueError(f"friction {friction} is not used: frictional=False has none")
        unknown = xi is not None and np.isinf(xi) and xi > 0 and covariance is None
        # Checked as for any ξ, though with ξ = ∞ nothing is left of the kind of noise.
        known = sources(network, noise, covariance, None if unknown else xi)
        if data == "sizes" and known.moves:
            raise ValueError(
                "data='sizes' takes directions as exact: position noise needs data='all'"
            )
        weak = None if unknown else known
        problem = posterior(
            network, stiffness, friction, weak,
            pressure=pressure, data=data, frictional=frictional,
        )  # fmt: skip
        f, y, more = bounded_forces(problem)
        more["noise"] = y
        return _result(equation, f, _imbalance(equation, f), method, "clarabel", more)
    if method == "direct":
        fn = stiffness * network.overlaps
        if not frictional:
            if solver != "auto" or tol is not None:
                raise ValueError("method 'direct' without friction solves nothing: no solver, tol")
            residual = equation.M @ fn - equation.balance_rhs()
            return _result(equation, fn, residual, method, "none")
    elif not frictional:
        raise ValueError("method 'transverse' finds tangential forces: frictional=False has none")
    elif normal_forces is None:
        raise ValueError("method 'transverse' needs normal_forces")
    else:
        fn = real_array("normal_forces", normal_forces, (network.contacts,), "contact")
    return _transverse(equation, fn, method, solver, tol)


def _gppsz(
    equation: ForceEquation, stiffness: float, solver: str, tol: float | None
) -> Reconstruction:
    system, b = equation.matrices.system, equation.rhs(stiffness)
    f = system.solve(b, solver, tol)
    return _result(equation, f, equation.G @ f - b, "gppsz", system.solver_for(solver))


def _transverse(
    equation: ForceEquation, fn: Floats, method: str, solver: str, tol: float | None
) -> Reconstruction:
    matrices = equation.matrices
    b = equation.balance_rhs() - matrices.M_normal @ fn
    ft = matrices.transverse.solve(b, solver, tol)
    residual = matrices.M_tangential @ ft - b
    used = matrices.transverse.solver_for(solver)
    return _result(equation, np.concatenate([fn, ft]), residual, method, used)


def _imbalance(equation: ForceEquation, forces: Floats) -> Floats:
    return equation.M @ forces - equation.balance_rhs()


def _result(
    equation: ForceEquation,
    forces: Floats,
    residual: Floats,
    method: str,
    solver: str,
    more: Mapping[str, Any] | None = None,
) -> Reconstruction:
    c = equation.network.contacts
    normal = forces[:c]
    diagnostics = {
        "rows": len(residual),
        "unknowns": equation.unknowns,
        "hyperstaticity": equation.hyperstaticity,
        "negative": int((normal < 0).sum()),
        **(more or {}),
    }
    tangential = forces[c:] if equation.frictional else np.zeros(c)
    rms = float(np.sqrt(np.mean(residual**2)))
    return Reconstruction(
        frozen(normal), frozen(tangential), frozen(forces), rms, method, solver, diagnostics
    )
