"""The quadratic program of `bounded`, in units of f̄ and scaled for the solver.

What is told of the mean stress are rows (`scaling.estimators.told.mean_stress`), with noise of
their own where it has an error bar. Where that does not fix f̄, forces are f̄ s φ with φ, of mean
1, of the prior in the program for f/f̄, and s unknown but for the pressure told: the width of the
prior goes with s, so that small forces are no likelier than large ones. At the forces f̄ φ' of the
last pass, s = 1 + t,

    f/f̄ = φ + φ' t

and the next pass has the mean force f̄ (1 + t).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_array, csr_array, diags_array, eye_array, hstack

from packing.arguments.arrays import Floats
from scaling.equation.global_moments import moments_left_free
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.bounded.stress_data import stress_data

NO_LIMIT = 1e8
"""Friction above which |f_t| <= μ f_n asks for f_n >= 0 within the tolerance of the solver."""
WEAK = 0.1
"""Friction below which f_n >= 0 is asked for by itself."""

Shift = tuple[Floats, Floats, Floats, Floats, Floats]
"""Standard normals by which data, prior mean, second order, and the stress and loads that were
told with an error bar move: (k,), (n,), (c,), (u,), the pressure first, and (l,)."""


@dataclass(frozen=True, eq=False)
class Program:
    """min ½ zᵀP z + qᵀz, equal z = b, cone z <= 0 in z = (φ ; g η ; free moments ; noise of the
    loads ; of the stress ; t ; κ gap/f̄ ; second order), no t and φ = f/f̄ where f̄ is fixed."""

    P: Floats
    q: Floats
    equal: csr_array
    b: Floats
    cone: csr_array
    mean_force: float
    g: float
    unknowns: int
    sources: int
    explicit: slice
    """The rows that give f_n/f̄ in terms of the rest, for data="all"; none else."""
    posterior: Posterior
    place: int = 0
    """Of t in z."""
    growing: Floats | None = None
    """φ' (n,), where f̄ is not fixed."""
    erring: tuple[int, int] = (0, 0)
    """Where in z the noise of the loads begins and ends."""

    def balance_rhs(self, z: Floats) -> Floats:
        """-|F_ext⟩ with the errors of the loads that z has found taken out."""
        p = self.posterior
        told, E = p.equation.balance_rhs(), p.load_errors
        if not E.shape[1]:
            return told
        mine = slice(*self.erring)
        return told + E @ (z[mine] * np.sqrt(self.P[mine]))

    def forces(self, z: Floats) -> Floats:
        """f of z (n,), or of (n, draws)."""
        φ = z[: self.unknowns]
        if self.growing is not None:
            φ = φ + np.multiply.outer(self.growing, self.growth(z))
        return self.mean_force * φ

    def growth(self, z: Floats) -> Floats:
        """t, a number or (draws,)."""
        if self.growing is None:
            return np.zeros(z.shape[1:])
        return z[self.place]

    def noise(self, z: Floats) -> Floats:
        """η of z."""
        return z[self.unknowns : self.unknowns + self.sources] / self.g


def program_of(
    p: Posterior,
    last: Floats,
    shift: Shift | None = None,
    curved: bool = False,
) -> Program:
    """The program of a posterior, with the turning of directions at the forces `last`; if
    `curved` with the second order of distances too, see `_curvature`."""
    equation, f0, c, n = p.equation, p.mean_force, p.equation.network.contacts, p.equation.unknowns
    k = 0 if p.noise is None else p.noise.count
    # Effect of η on f/f̄, and g η: unit prior for weak noise, unit effect for strong noise.
    strength = 0.0 if p.noise is None else p.stiffness * p.noise.xi / f0
    scatter = strength * p.scatter
    g = max(1.0, float(np.sqrt(np.mean(scatter**2))))
    η0, (mean, width) = np.zeros(k), p.prior.of_contacts(c, n, p.closed)
    if shift is not None:
        η0, mean = g * shift[0], mean + width * shift[1]

    moments = moments_left_free(equation, p.load_errors)
    of_loads = p.load_errors / f0
    size = np.maximum(1.0, np.sqrt(of_loads.multiply(of_loads).sum(axis=0)))
    m, l, s = equation.M.shape[0], len(size), moments.shape[1]
    moments = csr_array(hstack([moments, -of_loads @ diags_array(1 / size)]))
    turning, data, effect, found = data_rows(p, last / f0, strength / g, g)
    gaps = csr_array((len(found), c if p.gaps else 0))
    if p.gaps:
        gaps = csr_array(-eye_array(c))
    slack, g_slack = csr_array((len(found), 0)), 1.0
    if curved:
        found, slack, g_slack = _second_order(p, found, None if shift is None else shift[2])
    told = stress_data(p, last / f0, None if shift is None else shift[3])
    s, v, w = s + l, gaps.shape[1], slack.shape[1]
    u, i = told.noise.shape[1], len(told.sums)
    equal = block_array(
        [
            [equation.M, turning, moments, told.grow(equation.M), *_zeros(m, v, w)],
            [data, effect, *_zeros(len(found), s), told.grow(data), gaps, slack],
            [told.rows, *_zeros(i, k, s), told.noise, *_zeros(i, v, w)],
        ]
    )
    ζ0 = np.zeros(l) if shift is None else shift[4]
    rhs = equation.balance_rhs() / f0 + of_loads @ ζ0
    b = [rhs + turning @ η0, found + effect @ η0, told.sums]
    limits = _cone(c, p.friction, equation.frictional)
    shut = [*_zeros(v, n, k, s, u), -eye_array(v), *_zeros(v, w)]
    held = limits.shape[0]
    cone = block_array(
        [[limits, *_zeros(held, k, s), told.grow(limits), *_zeros(held, v, w)], shut]
    )
    P = np.concatenate(
        [
            width**-2.0,
            np.full(k, g**-2.0),
            np.zeros(s - l),
            size**-2.0,
            told.P,
            np.zeros(v),
            np.full(w, g_slack**-2.0),
        ]
    )
    # A gap has an exponential prior of the mean by which the overlap scatters.
    price = 1 / scatter if p.gaps else np.zeros(v)
    q = np.concatenate([-mean / width**2, np.zeros(k + s), told.q, price, np.zeros(w)])
    explicit = slice(m, m + (c if p.noise is not None and p.data == "all" else 0))
    return Program(
        P, q, csr_array(equal), np.concatenate(b), csr_array(cone), f0, g, n, k, explicit, p,
        n + k + s + u - 1, told.growing, (n + k + s - l, n + k + s),
    )  # fmt: skip


def shift_sizes(posterior: Posterior) -> tuple[int, int, int, int, int]:
    """Numbers of standard normals in a `Shift`."""
    k = 0 if posterior.noise is None else posterior.noise.count
    equation = posterior.equation
    told, loads = posterior.stress.noisy, posterior.load_errors.shape[1]
    return k, equation.unknowns, equation.network.contacts, told, loads


def _zeros(rows: int, *columns: int) -> list[csr_array]:
    return [csr_array((rows, m)) for m in columns]


def _second_order(
    p: Posterior, found: Floats, shift: Floats | None
) -> tuple[Floats, csr_array, float]:
    """The data with the mean of the second order, the columns of its noise, and their scale."""
    bias, spread = _curvature(p)
    g = max(1.0, float(spread.max()))
    found = found + bias
    if shift is not None:
        found = found - spread * shift
    return found, csr_array(diags_array(-spread / g)), g


def _curvature(p: Posterior) -> tuple[Floats, Floats]:
    """Mean and standard deviation (c,) of what distances gain beyond first order, as κ δr/f̄.

    A relative displacement u_t across n lengthens r by u_t²/2r: mean ⟨u_t²⟩/2r, deviation √2
    times that. Second order in ξ, but measured in deformations it is ξ²/Δ.
    """
    assert p.noise is not None
    network = p.equation.network
    across = p.noise.across(network) * p.noise.xi
    mean = across.multiply(across).sum(axis=1) / (2 * network.distances)
    mean = p.equation.stiffened(mean * (p.stiffness / p.mean_force))
    return mean, np.sqrt(2) * mean


def data_rows(
    p: Posterior, φ: Floats, strength: float, g: float
) -> tuple[csr_array, csr_array, csr_array, Floats]:
    """(turning of the directions, rows for f, rows for g η, data) in units of f̄."""
    equation, network, n = p.equation, p.equation.network, p.equation.unknowns
    if p.noise is None:
        rows = equation.M.shape[0]
        return csr_array((rows, 0)), csr_array((0, n)), csr_array((0, 0)), np.zeros(0)
    B = csr_array(p.noise.overlaps(network) * strength)
    # True directions: M - D y, as x̃ = x + L_x y.
    turning = csr_array(p.noise.balance(network, φ) * (-p.noise.xi / g))
    if p.data == "all":
        overlaps = equation.stiffened(network.overlaps * (p.stiffness / p.mean_force))
        return turning, csr_array(eye_array(network.contacts, n)), equation.stiffened(B), overlaps
    t = equation.rhs()[equation.M.shape[0] :] / p.mean_force
    return turning, equation.matrices.closure, csr_array(equation.Q @ B), t


def _cone(contacts: int, friction: float, frictional: bool) -> csr_array:
    """Rows whose product with f must not be positive: ±f_t - μ f_n, or -f_n.

    Rows are scaled to entries up to 1, so that strong friction counts no more than weak.
    """
    one = eye_array(contacts)
    if not frictional:
        return csr_array(-one)
    push = [-one, 0 * one]
    if friction >= NO_LIMIT:
        return csr_array(block_array([push]))
    scale = 1 / max(1.0, friction)
    rows = [[-scale * friction * one, scale * one], [-scale * friction * one, -scale * one]]
    # The sum of the two says μ f_n >= 0: with weak friction that is hardly felt.
    return csr_array(block_array(rows if friction >= WEAK else [*rows, push]))
