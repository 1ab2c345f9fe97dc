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

On open networks p is not needed: the loads say 2 p A = -Σ x·F.
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

    mean : of f_n; normal, tangential : standard deviations of f_n and f_t, positive
    """

    mean: float = 1.0
    normal: float = 1.0
    tangential: float = 0.5

    def __post_init__(self) -> None:
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
    def mean_force(self) -> float:
        """f̄ = Σ f_n r/Σ r."""
        return self.virial / float(_lengths(self.equation.network).sum())


def virial_of(network: ContactNetwork, pressure: float | None) -> float:
    """Σ f_n r: 2 p A of a periodic cell, -Σ x·F of the loads if open. ValueError else."""
    if network.cell is not None:
        if pressure is None or not (np.isfinite(pressure) and pressure > 0):
            raise ValueError(f"pressure {pressure}: a periodic network needs a positive one")
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


def bounded_forces(
    posterior: Posterior, shift: tuple[Floats, Floats] | None = None
) -> tuple[Floats, Floats, dict[str, Any]]:
    """(f, η, the solver's report) at the maximum of the posterior.

    `shift` moves the data and the prior mean by noise of their own size, (k,) and (2c,)
    standard normals: see `scaling.credible`. Where noisy positions leave nothing feasible, the
    second order of the distances is let in as noise of its own (report: curved). ValueError:
    clarabel missing, or nothing feasible; RuntimeError: clarabel breaks down.
    """
    try:
        return _passes(posterior, shift, curved=False)
    except ValueError:
        if posterior.noise is None or not posterior.noise.moves:
            raise
    return _passes(posterior, shift, curved=True)


def _passes(
    posterior: Posterior, shift: tuple[Floats, Floats] | None, curved: bool
) -> tuple[Floats, Floats, dict[str, Any]]:
    f, noise = np.zeros(posterior.equation.unknowns), posterior.noise
    f[: posterior.equation.network.contacts] = posterior.mean_force
    passes = 2 if noise is not None and noise.moves else 1
    for _ in range(passes):  # the turning of directions is linear at the forces of the last pass
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
    shift: tuple[Floats, Floats] | None = None,
    curved: bool = False,
) -> Programme:
    """The programme of a posterior, with the turning of directions at the forces `last`; if
    `curved` with the second order of distances too, see `_curvature`."""
    equation, f0, c, n = p.equation, p.mean_force, p.equation.network.contacts, p.equation.unknowns
    k = 0 if p.noise is None else p.noise.count
    # g η: unit prior of η for weak noise, unit effect on f/f̄ for strong noise.
    strength = 0.0 if p.noise is None else p.stiffness * p.noise.xi / f0
    g = max(1.0, strength)
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
        bias, scatter = _curvature(p)
        g_slack = max(1.0, float(scatter.max()))
        found, slack = found + bias, csr_array(diags_array(-scatter / g_slack))
    s, v, w = moments.shape[1], gaps.shape[1], slack.shape[1]
    r = _lengths(equation.network)
    unit = np.linalg.norm(r)  # the pressure row has c entries: made to weigh like one contact
    pressure = csr_array((r / unit, (np.zeros(c, dtype=int), np.arange(c))), shape=(1, n))
    widths = (k, s, v, w)
    equal = block_array(
        [
            [equation.M, turning, moments, *_zeros(equation.M.shape[0], widths[2:])],
            [data, effect, *_zeros(len(found), widths[1:2]), gaps, slack],
            [pressure, *_zeros(1, widths)],
        ]
    )
    b = [equation.balance_rhs() / f0 + turning @ η0, found + effect @ η0, [p.virial / f0 / unit]]
    limits = _cone(c, p.friction, equation.frictional)
    shut = [csr_array((v, n)), *_zeros(v, (k, s)), -eye_array(v), *_zeros(v, (w,))]
    cone = block_array([[limits, *_zeros(limits.shape[0], widths)], shut])
    P = np.concatenate(
        [width**-2.0, np.full(k, g**-2.0), np.zeros(s + v), np.full(w, g_slack**-2.0)]
    )
    # A gap has an exponential prior of mean √2 ξ, the scatter of the distance of two centres.
    price = 1 / (np.sqrt(2) * strength) if p.gaps else 0.0
    q = np.concatenate([-mean / width**2, np.zeros(k + s), np.full(v, price), np.zeros(w)])
    first = equation.M.shape[0]
    explicit = slice(first, first + (c if p.noise is not None and p.data == "all" else 0))
    return Programme(
        P, q, csr_array(equal), np.concatenate(b), csr_array(cone), f0, g, n, k, explicit
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
    friction: float,
    noise: Sources | None,
    *,
    pressure: float | None = None,
    data: str = "all",
    frictional: bool = True,
    prior: Prior | None = None,
    gaps: bool = False,
) -> Posterior:
    """Collect a posterior; `noise` None means that sizes are not known at all (ξ = ∞).

    With `gaps` (for data="all") a contact of the list may be open, f_n = κ (σ - r + gap) with
    gap >= 0: for lists inferred from the geometry, where some are false.
    """
    if gaps and (data != "all" or noise is None):
        raise ValueError("gaps are for data='all' with noise of finite strength")
    if not (np.isfinite(friction) and friction >= 0):
        raise ValueError(f"friction {friction}: it cannot be negative")
    if data == "sizes" and noise is not None and noise.moves:
        raise ValueError("data='sizes' takes directions as exact: position noise needs data='all'")
    return Posterior(
        force_equation(network, frictional),
        stiffness,
        noise,
        friction,
        virial_of(network, pressure),
        data,
        Prior() if prior is None else prior,
        gaps,
    )
