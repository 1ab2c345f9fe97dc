"""Maximum a posteriori with what is certain about contacts: they push, and friction is limited.

    min  |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ]     over f, y

    subject to   M|f⟩ = -|F_ext⟩ ,    f_n >= 0 ,    |f_t| <= μ f_n ,    Σ f_n r = 2 p A ,
                 f_n = κ (σ̃ - r̃ - B y)                 data="all"
                 Q f_n = κ (Q|σ̃⟩ - Λ - Q B y)          data="sizes"

a convex quadratic programme, solved by clarabel (interior point). B y is the effect of the noise
on the data, see `scaling.sources`. The prior: mean f̄ = 2 p A/Σ r, a = 1 and b = 1/2. For ξ << Δ
the data decide, for ξ >> Δ what is left is the prior among the states that balance, so the
error saturates where that of linear estimates grows as ξ/Δ.

On open networks p is not needed: the loads say 2 p A = -Σ x·F.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import (
    coo_array,
    csc_array,
    csc_matrix,
    csr_array,
    diags_array,
    eye_array,
    hstack,
)

from scaling.checks import Floats
from scaling.constrained import global_moments
from scaling.equation import ForceEquation, force_equation
from scaling.sources import Sources

if TYPE_CHECKING:
    from scaling.network import ContactNetwork


@dataclass(frozen=True)
class Prior:
    """What forces are before any geometry is measured, in units of f̄.

    mean : of f_n; normal, tangential : standard deviations of f_n and f_t
    """

    mean: float = 1.0
    normal: float = 1.0
    tangential: float = 0.5


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
    """(f, y, the solver's report) at the maximum of the posterior.

    `shift` moves the data and the prior mean by noise of their own size, (k,) and (2c,)
    standard normals: see `scaling.credible`. ValueError: clarabel missing, or nothing feasible.
    """
    if find_spec("clarabel") is None:
        raise ValueError("method 'bounded' needs clarabel: pip install 'packing-forces[convex]'")
    f, noise = np.zeros(posterior.equation.unknowns), posterior.noise
    passes = 2 if noise is not None and noise.moves else 1
    for _ in range(passes):  # the turning of directions is linear at the forces of the last pass
        f, y, report = _solve(posterior, f, shift)
    return f, y, report


def _solve(
    p: Posterior, last: Floats, shift: tuple[Floats, Floats] | None
) -> tuple[Floats, Floats, dict[str, Any]]:
    equation, network, f0 = p.equation, p.equation.network, p.mean_force
    c, n = network.contacts, p.equation.unknowns
    k = 0 if p.noise is None else p.noise.count
    # y = g η: unit prior of η for weak noise, unit effect on f/f̄ for strong noise.
    strength = 0.0 if p.noise is None else p.stiffness * p.noise.xi / f0
    g = max(1.0, strength)
    η0 = np.zeros(k) if shift is None else shift[0]
    width = np.full(n, p.prior.normal)
    width[c:] = p.prior.tangential
    mean = np.zeros(n)
    mean[:c] = p.prior.mean
    if shift is not None:
        mean = mean + width * shift[1]

    balance, equal = equation.M, [equation.balance_rhs() / f0]
    y_balance = csr_array((balance.shape[0], k))
    B: Any = csr_array((c, k))
    if p.noise is not None:
        B = p.noise.overlaps(network) * (strength / g)
        if p.noise.moves and last.any():
            # True directions: M - D y, as x̃ = x + L_x y.
            y_balance = p.noise.balance(network, last / f0) * (-p.noise.xi / g)
            equal[0] = equal[0] + y_balance @ (g * η0)
    moments = global_moments(network) if equation.frictional else csr_array((balance.shape[0], 0))
    s = moments.shape[1]
    rows = [hstack([balance, y_balance, moments])]
    if k:
        wanted = p.stiffness / f0
        if p.data == "all":
            rows.append(hstack([eye_array(c, n), B, csr_array((c, s))]))
            equal.append(wanted * network.overlaps + B @ (g * η0))
        else:
            Q = equation.Q
            rows.append(hstack([equation.matrices.closure, Q @ B, csr_array((Q.shape[0], s))]))
            t = equation.rhs(p.stiffness)[balance.shape[0] :] / f0
            equal.append(t + Q @ (B @ (g * η0)))
    pressure = np.zeros(n + k + s)
    pressure[:c] = _lengths(network)
    equal.append(np.array([p.virial / f0]))
    # The row has c entries: scaled to unit norm, it weighs like one contact.
    scale = np.linalg.norm(pressure)
    rows.append(csr_array(pressure[None] / scale))
    equal[-1] = equal[-1] / scale
    inequalities = _cone(c, p.friction, equation.frictional)
    rows.append(hstack([inequalities, csr_array((inequalities.shape[0], k + s))]))

    P = diags_array(np.concatenate([width**-2.0, np.full(k, g**-2.0), np.zeros(s)]))
    q = np.concatenate([-mean / width**2, np.zeros(k + s)])
    z, report = _clarabel(P, q, rows, np.concatenate(equal), inequalities.shape[0])
    return f0 * z[:n], z[n : n + k] / g, report


def _cone(contacts: int, friction: float, frictional: bool) -> csr_array:
    """Rows whose product with f must not be positive: ±f_t - μ f_n, or -f_n."""
    I = eye_array(contacts)
    if not frictional:
        return csr_array(-I)
    upper, lower = hstack([-friction * I, I]), hstack([-friction * I, -I])
    stacked = [upper, lower] if friction > 0 else [upper, lower, hstack([-I, 0 * I])]
    return csr_array(_stack(stacked))


def _stack(rows: list[Any]) -> Any:
    from scipy.sparse import vstack

    return vstack(rows)


def _clarabel(
    P: Any, q: Floats, rows: list[Any], equal: Floats, cone: int
) -> tuple[Floats, dict[str, Any]]:
    import clarabel

    A = csc_array(coo_array(_stack(rows)))
    A.eliminate_zeros()
    b = np.concatenate([equal, np.zeros(cone)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    problem = clarabel.DefaultSolver(
        csc_matrix(P), q, csc_matrix(A), b,
        [clarabel.ZeroConeT(len(equal)), clarabel.NonnegativeConeT(cone)], settings,
    )  # fmt: skip
    solution = problem.solve()
    status = str(solution.status)
    if status not in ("Solved", "AlmostSolved"):
        raise ValueError(
            f"no forces satisfy balance, friction and pressure together: clarabel says {status} "
            f"after {solution.iterations} iterations; is the friction or the contact list wrong?"
        )
    z = np.array(solution.x)
    report = {
        "status": status,
        "iterations": int(solution.iterations),
        "tolerance": float(
            max(abs((A @ z - b)[: len(equal)]).max(), (A @ z - b)[len(equal) :].max(), 0)
        ),
    }
    return z, report


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
) -> Posterior:
    """Collect a posterior; `noise` None means that sizes are not known at all (ξ = ∞)."""
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
    )
