"""The quadratic program of `bounded`, in units of f̄ and scaled for the solver.

Where distances are no data, in data="sizes" and for ξ = ∞, the pressure needs none: directions
are exact then, and the sum over branches r n = x_j - x_i + H is, for forces that balance,

    Σ f_n r = Σ (f_n n - f_t t) · (r n) = Σ (f_n n - f_t t) · H

with H the lattice vector that a contact crosses: the force across the sides of the cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_array, csr_array, diags_array, eye_array

from packing.arguments.arrays import Floats
from scaling.equation.global_moments import global_moments
from scaling.estimators.bounded.posterior import Posterior

_NO_LIMIT = 1e8
"""Friction above which |f_t| <= μ f_n asks for f_n >= 0 within the tolerance of the solver."""
_WEAK = 0.1
"""Friction below which f_n >= 0 is asked for by itself."""

Shift = tuple[Floats, Floats, Floats]
"""Standard normals by which data, prior mean and second order move, (k,), (n,) and (c,)."""


@dataclass(frozen=True, eq=False)
class Program:
    """min ½ zᵀP z + qᵀz, equal z = b, cone z <= 0 in z = (f/f̄ ; g η ; free moments ; κ gap/f̄ ;
    second order)."""

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

    def forces(self, z: Floats) -> Floats:
        """f of z (n,), or of (n, draws)."""
        return self.mean_force * z[: self.unknowns]

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
    η0, width, mean = np.zeros(k), np.full(n, float(p.prior.normal)), np.zeros(n)
    width[c:] = p.prior.tangential
    mean[:c] = p.prior.mean
    if shift is not None:
        η0, mean = g * shift[0], mean + width * shift[1]

    moments = csr_array((equation.M.shape[0], 0))
    if equation.frictional:
        moments = global_moments(equation.network)
    turning, data, effect, found = data_rows(p, last / f0, strength / g, g)
    gaps = csr_array((len(found), c if p.gaps else 0))
    if p.gaps:
        gaps = csr_array(-eye_array(c))
    slack, g_slack = csr_array((len(found), 0)), 1.0
    if curved:
        bias, spread = _curvature(p)
        g_slack = max(1.0, float(spread.max()))
        found, slack = found + bias, csr_array(diags_array(-spread / g_slack))
        if shift is not None:
            found = found - spread * shift[2]
    s, v, w = moments.shape[1], gaps.shape[1], slack.shape[1]
    pressure, virial = _pressure(p)
    widths = (k, s, v, w)
    equal = block_array(
        [
            [equation.M, turning, moments, *_zeros(equation.M.shape[0], widths[2:])],
            [data, effect, *_zeros(len(found), widths[1:2]), gaps, slack],
            [pressure, *_zeros(len(virial), widths)],
        ]
    )
    b = [equation.balance_rhs() / f0 + turning @ η0, found + effect @ η0, virial]
    limits = _cone(c, p.friction, equation.frictional)
    shut = [csr_array((v, n)), *_zeros(v, (k, s)), -eye_array(v), *_zeros(v, (w,))]
    cone = block_array([[limits, *_zeros(limits.shape[0], widths)], shut])
    P = np.concatenate(
        [width**-2.0, np.full(k, g**-2.0), np.zeros(s + v), np.full(w, g_slack**-2.0)]
    )
    # A gap has an exponential prior of the mean by which the overlap scatters.
    price = 1 / scatter if p.gaps else np.zeros(v)
    q = np.concatenate([-mean / width**2, np.zeros(k + s), price, np.zeros(w)])
    first = equation.M.shape[0]
    explicit = slice(first, first + (c if p.noise is not None and p.data == "all" else 0))
    return Program(
        P, q, csr_array(equal), np.concatenate(b), csr_array(cone), f0, g, n, k, explicit,
        p,
    )  # fmt: skip


def _zeros(rows: int, columns: tuple[int, ...]) -> list[csr_array]:
    return [csr_array((rows, m)) for m in columns]


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


def _pressure(p: Posterior) -> tuple[csr_array, Floats]:
    """The row of Σ f_n r = 2 p A for f/f̄, and its right-hand side: of r̃ where they are data, else
    of the forces that cross the sides of the cell. None on open networks, where balance implies
    it."""
    network, n = p.equation.network, p.equation.unknowns
    if network.cell is None:
        return csr_array((0, n)), np.zeros(0)
    row = np.zeros(n)
    if p.noise is not None and p.data == "all":
        row[: network.contacts] = network.distances
    else:
        crossed = network.images @ network.cell
        row[: network.contacts] = np.sum(network.normals * crossed, axis=1)
        if p.equation.frictional:
            row[network.contacts :] = -np.sum(network.tangents * crossed, axis=1)
    unit = np.linalg.norm(row)  # it has up to 2c entries: made to weigh like one contact
    return csr_array(row[None] / unit), np.array([p.virial / p.mean_force / unit])


def _cone(contacts: int, friction: float, frictional: bool) -> csr_array:
    """Rows whose product with f must not be positive: ±f_t - μ f_n, or -f_n.

    Rows are scaled to entries up to 1, so that strong friction counts no more than weak.
    """
    one = eye_array(contacts)
    if not frictional:
        return csr_array(-one)
    push = [-one, 0 * one]
    if friction >= _NO_LIMIT:
        return csr_array(block_array([push]))
    scale = 1 / max(1.0, friction)
    rows = [[-scale * friction * one, scale * one], [-scale * friction * one, -scale * one]]
    # The sum of the two says μ f_n >= 0: with weak friction that is hardly felt.
    return csr_array(block_array(rows if friction >= _WEAK else [*rows, push]))
