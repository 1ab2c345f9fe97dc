"""Maximum a posteriori with what is certain about contacts: they push, and friction is limited.

    min  |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ]     over f, y

    subject to   M|f⟩ = -|F_ext⟩ ,    f_n >= 0 ,    |f_t| <= μ f_n ,    Σ f_n r = 2 p A ,
                 f_n = κ (σ̃ - r̃ - B y)                 data="all"
                 Q f_n = κ (Q|σ̃⟩ - Λ - Q B y)          data="sizes"

a convex quadratic programme, solved by clarabel (interior point). B y is the effect of the noise
on the data, see `scaling.sources`. Noisy positions turn directions, so M in the first condition
is M(x̃) - D y: no grain has to balance in directions that are wrong, but the y that rights it is
the same that rights the overlaps, and weighed. What is linear in y is wrong by ~ξ²/Δ in forces;
near isostaticity (without friction) that can leave nothing feasible: then it is noise of its own.
The prior: mean f̄ = 2 p A/Σ r, a = 1 and b = 1/2. For ξ << Δ
the data decide, for ξ >> Δ what is left is the prior among the states that balance, so the
error saturates where that of linear estimates grows as ξ/Δ.

Where distances are no data, in data="sizes" and for ξ = ∞, the pressure needs none: directions
are exact then, and the sum over branches r n = x_j - x_i + H is, for forces that balance,

    Σ f_n r = Σ (f_n n - f_t t) · (r n) = Σ (f_n n - f_t t) · H

with H the lattice vector that a contact crosses: the force across the sides of the cell.

On open networks p is not needed: that the loads are balanced says Σ f_n r = 2 p A = -Σ x·F.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import block_array, csr_array, diags_array, eye_array

from scaling.checks import Floats
from scaling.constrained import global_moments
from scaling.convex import minimise
from scaling.equation import ForceEquation, force_equation
from scaling.sources import Sources

if TYPE_CHECKING:
    from scaling.network import ContactNetwork


@dataclass(frozen=True)
class Prior:
    """What forces are before any geometry is measured, in units of f̄.

    mean : of f_n, finite; normal, tangential : standard deviations of f_n and f_t, positive
    """

    mean: float = 1.0
    normal: float = 1.0
    tangential: float = 0.5

    def __post_init__(self) -> None:
        if not np.isfinite(self.mean):
            raise ValueError(f"prior: mean = {self.mean} is not finite")
        for name in ("normal", "tangential"):
            width = getattr(self, name)
            if not (np.isfinite(width) and width > 0):
                raise ValueError(f"prior: {name} = {width}, a standard deviation is positive")


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is minimised, and the linear data model; see `bounded_forces`."""

    equation: ForceEquation
    stiffness: float
    noise: Sources | None
    friction: float
    virial: float
    data: str
    prior: Prior
    gaps: bool = False

    @property
    def lengths(self) -> Floats:
        """r (c,) as far as data go: r̃, or σ̃ if sizes are all, or ⟨σ⟩ if nothing is."""
        network = self.equation.network
        if self.noise is None:
            return np.full(network.contacts, network.mean_diameter)
        return network.distances if self.data == "all" else network.sigma

    @property
    def mean_force(self) -> float:
        """f̄ = Σ f_n r/Σ r, the unit of the programme and the mean of the prior."""
        return self.virial / float(self.lengths.sum())


def virial_of(network: ContactNetwork, pressure: float | None) -> float:
    """Σ f_n r: 2 p A of a periodic cell, -Σ x·F of the loads if open.

    ValueError else, and for a periodic cell with loads: what they add to Σ f_n r depends on
    where the cell is cut.
    """
    if network.cell is not None:
        if pressure is None or not (np.isfinite(pressure) and pressure > 0):
            raise ValueError(f"pressure {pressure}: a periodic network needs a positive one")
        pushed = network.external[:, :2].any(axis=1)
        if pushed.any():
            i = int(np.argmax(pushed))
            F = network.external[i, :2]
            raise ValueError(
                f"the pressure of a periodic cell does not give Σ f_n r with loads: grain {i} has "
                f"({F[0]:.3g}, {F[1]:.3g}), one of {pushed.sum()}"
            )
        return 2 * pressure * abs(float(np.linalg.det(network.cell)))
    if pressure is not None:
        raise ValueError("method 'bounded' does not use pressure if the network is open")
    if network.positions is None:
        raise ValueError("the loads on an open network give Σ f_n r only with positions")
    virial = -float(np.sum(network.positions * network.external[:, :2]))
    if not virial > 0:
        raise ValueError(f"the external loads do not compress: -Σ x·F = {virial:.3g}")
    return virial


def flat_guess(network: ContactNetwork, pressure: float | None = None) -> Floats:
    """(2c,) the guess that knows only the load: f_n = f̄ = Σ f_n r/Σ r everywhere, f_t = 0."""
    fn = np.full(network.contacts, virial_of(network, pressure) / _lengths(network).sum())
    return np.concatenate([fn, np.zeros_like(fn)])


def bounded_forces(posterior: Posterior) -> tuple[Floats, Floats, dict[str, Any]]:
    """(f, η, the solver's report) at the maximum of the posterior.

    Where noisy positions leave nothing feasible, the second order of the distances is let in as
    noise of its own (report: curved). ValueError: clarabel missing, or nothing feasible;
    RuntimeError: clarabel breaks down.
    """
    try:
        return passes(posterior, curved=False)
    except ValueError:
        if posterior.noise is None or not posterior.noise.moves:
            raise
    return passes(posterior, curved=True)


Shift = tuple[Floats, Floats, Floats]
"""Standard normals by which data, prior mean and second order move, (k,), (n,) and (c,)."""


def passes(
    posterior: Posterior, curved: bool, shift: Shift | None = None
) -> tuple[Floats, Floats, dict[str, Any]]:
    """`bounded_forces` with the second order of distances, or without.

    `shift` moves every Gaussian by noise of its own size: see `scaling.credible`.
    """
    f, noise = np.zeros(posterior.equation.unknowns), posterior.noise
    f[: posterior.equation.network.contacts] = posterior.mean_force
    count = 2 if noise is not None and noise.moves else 1
    for _ in range(count):  # the turning of directions is linear at the forces of the last pass
        task = programme(posterior, f, shift, curved)
        z, report = minimise(task.P, task.q, task.equal, task.b, task.cone)
        f, η = task.forces(z), task.noise(z)
    return f, η, report | {"curved": curved}


@dataclass(frozen=True, eq=False)
class Programme:
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

    def forces(self, z: Floats) -> Floats:
        """f of z (n,), or of (n, draws)."""
        return self.mean_force * z[: self.unknowns]

    def noise(self, z: Floats) -> Floats:
        """η of z."""
        return z[self.unknowns : self.unknowns + self.sources] / self.g


def programme(
    p: Posterior,
    last: Floats,
    shift: Shift | None = None,
    curved: bool = False,
) -> Programme:
    """The programme of a posterior, with the turning of directions at the forces `last`; if
    `curved` with the second order of distances too, see `_curvature`."""
    equation, f0, c, n = p.equation, p.mean_force, p.equation.network.contacts, p.equation.unknowns
    k = 0 if p.noise is None else p.noise.count
    # Effect of η on f/f̄, and g η: unit prior for weak noise, unit effect for strong noise.
    strength = 0.0 if p.noise is None else p.stiffness * p.noise.xi / f0
    scatter = strength * _scatter(p)
    g = max(1.0, float(np.sqrt(np.mean(scatter**2))))
    η0, width, mean = np.zeros(k), np.full(n, float(p.prior.normal)), np.zeros(n)
    width[c:] = p.prior.tangential
    mean[:c] = p.prior.mean
    if shift is not None:
        η0, mean = g * shift[0], mean + width * shift[1]

    moments = csr_array((equation.M.shape[0], 0))
    if equation.frictional:
        moments = global_moments(equation.network)
    turning, data, effect, found = _data(p, last / f0, strength / g, g)
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
    return Programme(
        P, q, csr_array(equal), np.concatenate(b), csr_array(cone), f0, g, n, k, explicit
    )  # fmt: skip


def _scatter(p: Posterior) -> Floats:
    """(c,) standard deviations of the overlaps over ξ, a length; zeros if nothing is known."""
    network = p.equation.network
    if p.noise is None:
        return np.zeros(network.contacts)
    B = p.noise.overlaps(network)
    return np.sqrt(np.asarray(B.multiply(B).sum(axis=1)).ravel())


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
    mean = mean * (p.stiffness / p.mean_force)
    return mean, np.sqrt(2) * mean


def _data(
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
        overlaps = network.overlaps * (p.stiffness / p.mean_force)
        return turning, csr_array(eye_array(network.contacts, n)), B, overlaps
    t = equation.rhs(p.stiffness)[equation.M.shape[0] :] / p.mean_force
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
    """Rows whose product with f must not be positive: ±f_t - μ f_n, or -f_n."""
    one = eye_array(contacts)
    if not frictional:
        return csr_array(-one)
    rows = [[-friction * one, one], [-friction * one, -one]]
    # With μ > 0 the sum of the two says f_n >= 0.
    return csr_array(block_array(rows if friction > 0 else [*rows, [-one, 0 * one]]))


def _lengths(network: ContactNetwork) -> Floats:
    return network.sigma if network.positions is None else network.distances


def posterior(
    network: ContactNetwork,
    stiffness: float,
    friction: float | None,
    noise: Sources | None,
    *,
    pressure: float | None = None,
    data: str = "all",
    frictional: bool = True,
    prior: Prior | None = None,
    gaps: bool = False,
) -> Posterior:
    """Collect a posterior; `noise` None means that neither sizes nor distances are known (ξ = ∞).

    `friction` is not used, and may be None, with frictional=False. With `gaps` (for data="all")
    a contact of the list may be open, f_n = κ (σ - r + gap) with gap >= 0 of exponential prior,
    its mean the standard deviation of σ̃ - r̃: for lists inferred from the geometry, where some
    are false. ValueError: bad input, or gaps where a contact is known without noise.
    """
    if not (np.isfinite(stiffness) and stiffness > 0):
        raise ValueError(f"stiffness {stiffness}: it must be positive")
    if data not in ("all", "sizes"):
        raise ValueError(f"data {data!r}: choose 'all' or 'sizes'")
    if gaps and (data != "all" or noise is None):
        raise ValueError("gaps are for data='all' with noise of finite strength")
    if friction is None:
        if frictional:
            raise ValueError("a posterior with friction needs the friction coefficient")
        friction = 0.0
    if not (np.isfinite(friction) and friction >= 0):
        raise ValueError(f"friction {friction}: it cannot be negative")
    if data == "sizes" and noise is not None and noise.moves:
        raise ValueError("data='sizes' takes directions as exact: position noise needs data='all'")
    collected = Posterior(
        force_equation(network, frictional),
        stiffness,
        noise,
        friction,
        virial_of(network, pressure),
        data,
        Prior() if prior is None else prior,
        gaps,
    )
    if gaps and not _scatter(collected).all():
        e = int(np.argmin(_scatter(collected)))
        raise ValueError(f"gaps: the overlap of contact {e} is known without noise")
    return collected
