"""The full linear error map of an estimator: δf = κ ξ E η, E of (2c, k).

With B, D of `scaling.noise.noise_model` (D per κ) and G, M, Q of the equation, at the noise-free
solution

    gppsz       E = G⁺( -D ; Q B )
    balanced    E = the constrained solve of the same two data
    direct      E = ( B ; -M_t⁺(D + M_n B) )
    transverse  E = ( 0 ; -M_t⁺ D )
    optimal     E = ( B (1 - P) ; T ) ,  ( P ; T ) the constrained solve of C = M_n B + D

From it follow, for Gaussian noise, exactly: the rms gain K = ‖E‖_F/√(2c), the error of every
contact (row norms), the pattern of noise that hurts most (first right singular vector) and
the distribution of the squared error, Σ s² χ²₁ over the singular values s. Where E is
too large, ‖E‖_F² is the mean of |E z|² over random z, with an error bar.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats, real_array
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import (
    choice,
    flag,
    generator,
    instance,
    positive_number,
    whole_number,
)
from packing.progress import counted
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.estimators import balanced, optimal
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import Sources, sources

LINEAR = ("gppsz", "direct", "transverse", "balanced", "optimal")
_BLOCK = 256


@dataclass(frozen=True, eq=False)
class Response:
    """η -> δf/(κ ξ) of one estimator on one network, with the estimate of its error.

    `overlaps` and `balance` are B and D of the noise, D per κ; `forces` is φ = f/κ.
    """

    equation: ForceEquation
    method: str
    noise: Sources
    overlaps: csr_array
    balance: csr_array
    forces: Floats
    data: str
    solver: str
    tol: float | None

    def __call__(self, η: Floats) -> Floats:
        """(k, m) noise -> (2c, m) lengths; (c, m) if frictionless."""
        return self.solved(η).values

    def solved(self, η: Floats) -> Solved:
        """The response with its error, relative to what the noise does to the data."""
        of = {"gppsz": self._gppsz, "balanced": self._balanced, "optimal": self._optimal}
        return of.get(self.method, self._direct)(η)

    def _gppsz(self, η: Floats) -> Solved:
        matrices = self.equation.matrices
        b = np.concatenate([-(self.balance @ η), matrices.Q @ (self.overlaps @ η)])
        return matrices.system.solved(b, self.solver, self.tol)

    def _balanced(self, η: Floats) -> Solved:
        Q = self.equation.matrices.Q
        found = self.problem.solved(Q @ (self.overlaps @ η), -(self.balance @ η))
        return Solved(found.values[: self.equation.unknowns], found.error, found.solver)

    def _direct(self, η: Floats) -> Solved:
        δ = (1.0 if self.method == "direct" else 0.0) * (self.overlaps @ η)
        if not self.equation.frictional:
            return Solved(δ, 0.0, "none")
        matrices = self.equation.matrices
        found = matrices.transverse.solved(-(self.balance @ η) - matrices.M_normal @ δ)
        return Solved(np.concatenate([δ, found.values]), found.error, found.solver)

    def _optimal(self, η: Floats) -> Solved:
        k, n, unit = self.noise.count, self.equation.unknowns, self.noise.unit
        if self.data == "sizes":
            rows = self.equation.M.shape[0]
            QB = self.equation.matrices.Q @ (self.overlaps @ η) / unit
            b = np.concatenate([np.zeros((rows, *η.shape[1:])), QB])
            found = self.problem.solved(np.zeros_like(η), b)
            return Solved(unit * found.values[k : k + n], found.error, found.solver)
        C = self.equation.matrices.M_normal @ self.overlaps + self.balance
        found = self.problem.solved(np.zeros_like(η), C @ η / unit)
        u = found.values
        φ_t = unit * u[k : k + n - self.equation.network.contacts]
        values = np.concatenate([self.overlaps @ (η - u[:k]), φ_t])
        return Solved(values, found.error, found.solver)

    @cached_property
    def problem(self) -> ConstrainedLeastSquares:
        """What `balanced` and `optimal` solve."""
        if self.method == "balanced":
            return balanced.solver(self.equation)
        if self.data == "sizes":
            return optimal.size_problem(self.equation, self.noise)
        return optimal.geometric_problem(self.equation, self.noise, self.forces)[0]


@dataclass(frozen=True, eq=False)
class ErrorMap:
    """E of one estimator on one network. Made by `error_map`.

    Attributes
    ----------
    respond : (k, m) noise η -> (2c, m) errors δf/(κ ξ), lengths; (c, m) if frictionless
    sources, contacts, unknowns : k, c and 2c (c if frictionless)
    xi : ξ of a covariance, a length: κ ξ E Eᵀ κ ξ is then the covariance of the forces. 1 for
        noise of a convention, whose strength is the user's
    """

    respond: Response
    sources: int
    contacts: int
    unknowns: int
    xi: float = 1.0

    @cached_property
    def _computed(self) -> tuple[Floats, float]:
        """E, and the worst error estimate of its columns."""
        E, worst = np.empty((self.unknowns, self.sources)), 0.0
        blocks = range(0, self.sources, _BLOCK)
        for start in counted(blocks, len(blocks), f"error map of {self.respond.method}"):
            stop = min(start + _BLOCK, self.sources)
            η = np.zeros((self.sources, stop - start))
            η[np.arange(start, stop), np.arange(stop - start)] = 1.0
            some = self.respond.solved(η)
            E[:, start:stop], worst = some.values, max(worst, some.error)
        return E, worst

    @property
    def matrix(self) -> Floats:
        """E itself, (2c, k) dense."""
        return self._computed[0]

    @property
    def error_estimate(self) -> float:
        """Relative error of E by rounding and iteration, estimated by its solver.

        Never above `scaling.algebra.evidence.ACCEPTED`: a map that is not known so well is
        refused.
        """
        return self._computed[1]

    @property
    def gain(self) -> float:
        """K, a length (a number for a covariance): E_rms = K κ ξ/⟨|f|⟩."""
        return float(np.sqrt(np.sum(self.matrix**2) / self.unknowns))

    @property
    def covariance(self) -> Floats:
        """(2c, 2c): times (κ ξ)², the covariance of the forces."""
        return self.matrix @ self.matrix.T

    @property
    def per_component(self) -> Floats:
        """(2c,) standard deviation of f_n then f_t, over κ ξ."""
        return np.sqrt(np.sum(self.matrix**2, axis=1))

    @property
    def per_contact(self) -> Floats:
        """(c,) √(δf_n² + δf_t²), over κ ξ."""
        return np.sqrt(np.sum(self.per_component.reshape(-1, self.contacts) ** 2, axis=0))

    @cached_property
    def _modes(self) -> tuple[Floats, Floats]:
        λ, V = eigh(self.matrix.T @ self.matrix)
        return np.sqrt(np.maximum(λ[::-1], 0.0)), V[:, ::-1]

    @property
    def singular_values(self) -> Floats:
        """(k,) lengths, falling."""
        return self._modes[0]

    def worst_pattern(self) -> tuple[float, Floats, Floats]:
        """(s, η, δf): the unit noise pattern with the largest response |δf| = s (per κ ξ)."""
        s, V = self._modes
        η = V[:, 0] * np.sign(V[np.argmax(abs(V[:, 0])), 0])
        return float(s[0]), η, self.matrix @ η

    def sample(self, rng: np.random.Generator, draws: int) -> Floats:
        """(draws,) of rms(δf)/(κ ξ) over noise, from the singular values: no solve at all."""
        generator("rng", rng)
        whole_number("draws", draws, 1)
        s = self.singular_values
        refuse_beyond(f"draws = {draws}", 8.0 * draws * len(s))
        return np.sqrt(rng.chisquare(1.0, (draws, len(s))) @ s**2 / self.unknowns)

    def relative_spread(self) -> float:
        """Standard deviation of the squared error over its mean, √(2 Σ s⁴)/Σ s².

        ValueError: the map vanishes.
        """
        s = self.singular_values
        if not s.any():
            raise ValueError("the error map is 0: there is no error to be spread")
        return float(np.sqrt(2 * np.sum(s**4)) / np.sum(s**2))

    def estimated_gain(self, rng: np.random.Generator, probes: int) -> tuple[float, float]:
        """(K, its standard error) from random probes instead of the whole of E; for large N.

        |E z|²/(2c), z = ±1, has the mean K² whatever E; its scatter over probes gives the bar.
        A map that vanishes gives (0, 0).
        """
        generator("rng", rng)
        whole_number("probes", probes, 2)  # an error bar needs two
        refuse_beyond(f"probes = {probes}", 8.0 * probes)
        squares = np.array(
            [
                np.sum(self.respond(rng.choice([-1.0, 1.0], (self.sources, 1))) ** 2)
                for _ in range(probes)
            ]
        )
        squares /= self.unknowns
        K = float(np.sqrt(squares.mean()))
        if K == 0:
            return 0.0, 0.0
        return K, float(squares.std(ddof=1) / np.sqrt(probes) / (2 * K))


def error_map(
    network: ContactNetwork,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    covariance: Any = None,
    data: str = "all",
    frictional: bool = True,
    forces: ArrayLike | None = None,
    stiffness: float | None = None,
    solver: str = "auto",
    tol: float | None = None,
) -> ErrorMap:
    """The error map of `method` at the noise-free `network`.

    Parameters
    ----------
    method : "gppsz", "direct", "transverse", "balanced" or "optimal"
    noise, covariance : see `scaling.noise.noise_model`. E is the response per ξ; a covariance has
        a ξ of its own, `ErrorMap.xi`, so that errors of forces are κ `xi` times those of the map
    data : for `optimal`: "all", or "sizes" (with exact directions)
    forces : (2c,) or (c,), if positions are noisy: adds the turning of directions in M. Without
        them directions count as exact in M, and for `transverse` nothing would be left: refused
    stiffness : κ of these forces; by default the slope of f_n against the overlaps
    solver, tol : for `gppsz`: see `scaling.algebra.least_squares`

    ValueError: bad input, an argument not used, or an equation without a unique solution.
    """
    instance("network", network, ContactNetwork)
    choice("method", method, LINEAR)
    choice("data", data, ("all", "sizes"))
    flag("frictional", frictional)
    if data != "all" and (method != "optimal" or data != "sizes"):
        raise ValueError(f"method {method!r} does not use data={data!r}")
    if method == "transverse" and not frictional:
        raise ValueError("method 'transverse' finds tangential forces: frictional=False has none")
    if method != "gppsz" and (solver != "auto" or tol is not None):
        raise ValueError(f"method {method!r} does not use solver and tol")
    equation = force_equation(network, frictional)
    source = sources(network, noise, covariance)
    if not source.moves and (forces is not None or stiffness is not None):
        raise ValueError("size noise leaves G alone: forces and stiffness are not used")
    if source.moves and method == "transverse" and forces is None:
        raise ValueError("method 'transverse' feels position noise through δM f: give forces")
    if stiffness is not None:
        stiffness = positive_number("stiffness", stiffness)
    φ = np.zeros(equation.unknowns)
    if forces is not None:
        f = real_array("forces", forces, (equation.unknowns,), "component")
        φ = f / (slope(network, f) if stiffness is None else stiffness)
    elif stiffness is not None:
        raise ValueError("stiffness is not used without forces")
    B, D = source.overlaps(network), source.balance(network, φ)
    respond = Response(equation, method, source, B, D, φ, data, solver, tol)
    if method in ("balanced", "optimal"):
        _ = respond.problem  # what is not determined is refused now
    return ErrorMap(respond, source.count, network.contacts, equation.unknowns, source.xi)


def worst_pattern(
    network: ContactNetwork, method: str = "gppsz", noise: str = "diameter", **more: Any
) -> tuple[float, Floats, Floats]:
    """(s, η, δf): see `ErrorMap.worst_pattern`; arguments as for `error_map`."""
    return error_map(network, method, noise, **more).worst_pattern()


def slope(network: ContactNetwork, forces: Floats) -> float:
    """κ that fits f_n = κ δ best; ValueError if that is not positive."""
    δ, fn = network.overlaps, forces[: network.contacts]
    κ = float(fn @ δ / (δ @ δ)) if δ.any() else np.nan
    if not κ > 0:
        raise ValueError(f"forces and overlaps give the stiffness {κ}: give it as stiffness")
    return κ
