"""The least noise that leaves a packing in equilibrium, and the forces without it.

The data are the truth plus noise, R̃ = R + L_R y, x̃ = x + L_x y, y = ξ η. Find the y that is
most probable among those that leave a packing in equilibrium:

    min |y|²   subject to   M|f⟩ = -|F_ext⟩ ,  f_n = κ (σ - r)   at  R̃ - L_R y, x̃ - L_x y

With B and D of `scaling.noise.noise_model` one step of Gauss and Newton is, in lengths φ = f/κ,

    [ C  -M_t ] (y ; φ_t) = F_ext/κ + M_n δ + C y₀ ,      C = M_n B + D(φ) ,   δ = σ - r

linear for size noise; for position noise it is repeated at the new y (each correction is
smaller by ~ξ). Exact positions and noisy sizes are the singular limit: for Z <= 4 - 4/N the
3N - 2 balances determine all N sizes and c transverse forces, and the sizes measured are
redundant. That too is what `scaling.algebra.equality_least_squares` solves.

data="sizes" knows no distances. Then the unknowns are y and f, the conditions balance and
closure, Q f_n + κ Q B y = κ (Q|σ̃⟩ - Λ). Directions are exact in it.

A mean stress told adds its rows: see `scaling.estimators.optimal.stress_conditions`. Loads with
error bars have noise of their own in balance: `scaling.estimators.optimal.load_conditions`.

With a stiffness per contact φ = f/κ̄, of the mean, and B and δ in M_n B, M_n δ are times κ_e/κ̄.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array, hstack, vstack

from packing.arguments.arrays import Floats
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved, accepted
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.equation.global_moments import moments_left_free
from scaling.equation.places import places_of
from scaling.estimators.optimal.load_conditions import load_columns, row_scale
from scaling.estimators.optimal.stress_conditions import stress_conditions
from scaling.estimators.told.mean_stress import NOTHING, MeanStress
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import NoiseModel
from scaling.noise.source_places import source_places

_MOST_STEPS = 40
_SMALL = 1e-6
"""Relative change of the forces that may be left in the last step."""
_ROUNDING = 1e3 * np.finfo(float).eps
"""Rounding of an overlap, in ⟨σ⟩, with what the estimate makes of it."""


Before = tuple[ForceEquation, ConstrainedLeastSquares]
"""The equation that the steps began with, and the problem of the last one."""


def geometric_problem(
    equation: ForceEquation,
    noise: NoiseModel,
    φ: Floats,
    told: MeanStress = NOTHING,
    before: Before | None = None,
) -> tuple[ConstrainedLeastSquares, csr_array, csr_array]:
    """The problem in (y ; φ_t) linearised at φ = f/κ, with its B and C.

    Lengths in it (φ_t and the right-hand side C y) are in `noise.unit`, so that it has no unit.
    """
    start = None if before is None else before[0].matrices.transverse
    last = None if before is None else before[1]
    matrices, network = equation.matrices, equation.network
    B = equation.stiffened(noise.overlaps(network))
    C = csr_array(matrices.M_normal @ B + noise.balance(network, φ))
    of_loads = load_columns(equation, noise)
    blocks, at = [(C + of_loads) / noise.unit], [source_places(network, noise)]
    stress, c = stress_conditions(equation, noise, told), network.contacts
    of_stress = [stress.of_noise(B) / noise.unit]
    if equation.frictional:
        matrices.transverse.require_full_rank(start)
        free = moments_left_free(equation, noise.loads)
        blocks += [-matrices.M_tangential, free]
        of_stress += [stress.rows[:, c:], csr_array((len(stress.sums), free.shape[1]))]
        at.append(matrices.balancing.places)
    balances = row_scale(of_loads, noise.unit) @ hstack(blocks)
    conditions = vstack([balances, hstack(of_stress)])
    k, rest = noise.count, conditions.shape[1] - noise.count
    weights = hstack([eye_array(k), csr_array((k, rest))])
    name = "optimal estimate from sizes and distances"
    moments = blocks[-1].shape[1] if equation.frictional else 0
    places = places_of(equation, at, moments, rows=len(stress.sums))
    return ConstrainedLeastSquares(weights, conditions, name, places, last), B, C


def size_problem(
    equation: ForceEquation, noise: NoiseModel, told: MeanStress = NOTHING
) -> ConstrainedLeastSquares:
    """The problem in (y ; φ) of data="sizes", lengths in `noise.unit`."""
    if noise.moves:
        raise ValueError("data='sizes' takes directions as exact: position noise needs data='all'")
    matrices = equation.matrices
    matrices.system.require_full_rank()
    # Positions are exact: B is the response of σ.
    QB = matrices.Q @ noise.overlaps(equation.network) / noise.unit
    stress = stress_conditions(equation, noise, told)
    of_loads = load_columns(equation, noise)
    conditions = vstack(
        [
            row_scale(of_loads, noise.unit) @ hstack([of_loads / -noise.unit, equation.M]),
            hstack([QB, matrices.closure]),
            hstack([stress.errors / noise.unit, stress.rows]),
        ]
    )
    weights = hstack([eye_array(noise.count), csr_array((noise.count, equation.unknowns))])
    at = [source_places(equation.network, noise), matrices.places]
    places = places_of(equation, at, 0, rows=matrices.Q.shape[0] + len(stress.sums))
    return ConstrainedLeastSquares(weights, conditions, "optimal estimate from sizes", places)


def optimal_forces(
    equation: ForceEquation,
    stiffness: float,
    noise: NoiseModel,
    data: str,
    told: MeanStress = NOTHING,
) -> tuple[Solved, Floats, int, float]:
    """(f, y = the noise found in the data, steps, relative change of f in the last one).

    One step is exact unless positions are noisy. ValueError: f is not determined well enough;
    RuntimeError: the steps do not converge, as for noise that moves grains by a good part of their
    size.
    """
    unit = noise.unit
    if data == "sizes":
        sums = stress_conditions(equation, noise, told).sums
        t = np.concatenate([equation.rhs() / stiffness, sums]) / unit
        rows = equation.M.shape[0]
        t[:rows] = row_scale(load_columns(equation, noise), unit) @ t[:rows]
        found = size_problem(equation, noise, told).solved(np.zeros(noise.count), t)
        f = stiffness * unit * found.values[noise.count :]
        return _of_forces(found, stiffness * unit, f), found.values[: noise.count], 1, 0.0
    F = -equation.balance_rhs() / stiffness
    c, k = equation.network.contacts, noise.count
    y, φ = np.zeros(k), np.zeros(equation.unknowns)
    here, previous, change = equation, np.inf, np.inf
    before: Before | None = None
    scaled = row_scale(load_columns(equation, noise), unit)
    for step in range(_MOST_STEPS):
        problem, B, C = geometric_problem(here, noise, φ, told, before)
        before = equation, problem
        δ = here.stiffened(here.overlaps)
        stress = stress_conditions(here, noise, told)
        of_stress = stress.sums - stress.rows[:, :c] @ (δ + B @ y)
        b = np.concatenate([scaled @ (F + here.matrices.M_normal @ δ + C @ y), of_stress])
        found = problem.solved(np.zeros(k), b / unit)
        u = found.values
        y_new, φ_t = u[:k], unit * u[k : k + equation.unknowns - c]
        φ_new = np.concatenate([δ - B @ (y_new - y), φ_t])
        scale = float(np.linalg.norm(φ_new)) or 1.0
        change = float(np.linalg.norm(φ_new - φ)) / scale
        y, φ = y_new, φ_new
        solved = _of_forces(found, stiffness * unit, stiffness * φ)
        if not noise.moves:
            return solved, y, 1, 0.0
        # Done when the change is tiny, or no longer shrinks because it is rounding of overlaps.
        rounding = _ROUNDING * equation.network.mean_diameter / (scale / np.sqrt(len(φ)))
        small = change < max(_SMALL, rounding)
        if change < 1e-10 or (small and change > 0.5 * previous):
            return solved, y, step + 1, change
        previous = change
        here = _at(equation, _corrected(equation.network, noise, y))
    if small:
        return solved, y, step + 1, change
    raise RuntimeError(
        f"optimal estimate: after {_MOST_STEPS} steps the forces still change by {change:.1e} of "
        f"themselves; noise of xi = {noise.xi:g} is too strong to linearise"
    )


def _at(equation: ForceEquation, network: ContactNetwork) -> ForceEquation:
    """The same equation for another network with these contacts."""
    assert equation.law is not None
    return force_equation(network, equation.frictional).with_law(equation.law)


def _of_forces(found: Solved, unit: float, f: Floats) -> Solved:
    """`f`, and its share of the error of (y ; φ_t), which are in `unit` of force."""
    size = float(np.linalg.norm(f))
    error = found.error * unit * float(np.linalg.norm(found.values)) / size if size else 0.0
    return accepted(Solved(f, error, found.solver), "optimal estimate")


def _corrected(network: ContactNetwork, noise: NoiseModel, y: Floats) -> ContactNetwork:
    """The network with the noise y taken out of its data."""
    x = network.positions
    assert x is not None
    return network.replaced(
        positions=x - (noise.positions @ y).reshape(2, -1).T,
        radii=np.maximum(network.radii - noise.radii @ y, 1e-3 * network.radii),
    )
