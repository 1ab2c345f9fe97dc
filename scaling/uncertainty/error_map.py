"""The full linear error map of an estimator: δf = κ ξ E η, E of (2c, k).

With B, D of `scaling.noise.noise_model` (D per κ) and G, M, Q of the equation, at the noise-free
solution G f = b: δf = G⁺(δb - δG f), and as Q r = Λ whatever the noise, the parts of δb and δG in
the loop rows combine to κ Q δ(σ - r). So

    gppsz       E = G⁺( -D ; Q B )
    balanced    E = the constrained solve of the same two data
    direct      E = ( B ; -M_t⁺(D + M_n B) )
    transverse  E = ( 0 ; -M_t⁺ D )
    optimal     E = ( B (1 - P) ; T ) ,  ( P ; T ) the constrained solve of C = M_n B + D

each written where the estimator is (`LinearEstimator.respond`); of contacts that differ in
stiffness B is times κ_e/κ̄, and κ is the mean κ̄. From E follow, for Gaussian noise, exactly: the
rms gain K = ‖E‖_F/√(2c), the error of every contact (row norms), the pattern of noise that hurts
most (first right singular vector) and the distribution of the squared error, Σ s² χ²₁ over the
singular values s. Where E is too large, its row norms and ‖E‖_F are found from random probes, with
error bars (`scaling.algebra.probes`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh

from packing.arguments.arrays import Floats
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import generator, whole_number
from scaling.algebra.estimate import Estimate, Estimates
from scaling.algebra.probes import Probing, Squares
from scaling.estimators.response import AUTOMATIC, Response


@dataclass(frozen=True, eq=False)
class ErrorMap:
    """E of one estimator on one network. Made by `error_map`.

    Parameters
    ----------
    respond : Response
        (k, m) noise η -> (2c, m) errors δf/(κ ξ), lengths; (c, m) if frictionless
    probing : Probing
        How many random probes `gain`, `per_component` and `per_contact` are from, if any; the
        rest needs the whole of E, and takes it

    Notes
    -----
    `sources`, `contacts` and `unknowns` are k, c and 2c (c if frictionless). `xi` is ξ of a
    covariance, a length: κ ξ E Eᵀ κ ξ is then the covariance of the forces; 1 for noise of a
    convention, whose strength is the user's.

    Examples
    --------
    >>> from scaling import ContactNetwork, error_map
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> E = error_map(triangle)
    >>> E.matrix.shape, f"{E.gain:.3f}", f"{E.singular_values[0]:.3f}"
    ((6, 3), '0.240', '0.416')
    """

    respond: Response
    probing: Probing = AUTOMATIC

    @property
    def probes(self) -> int:
        """Probes behind `gain`, `per_component` and `per_contact`; 0: they are exact."""
        return self.probing.count(self.sources)

    @property
    def sources(self) -> int:
        """The number of independent sources of noise, k."""
        return self.respond.noise.count

    @property
    def contacts(self) -> int:
        """The number of contacts, c."""
        return self.respond.equation.network.contacts

    @property
    def unknowns(self) -> int:
        """2c, or c without friction."""
        return self.respond.equation.unknowns

    @property
    def xi(self) -> float:
        """ξ of the noise."""
        return self.respond.noise.xi

    @cached_property
    def _computed(self) -> tuple[Floats, float]:
        """E, and the worst error estimate of its columns."""
        n, k = self.unknowns, self.sources
        refuse_beyond(f"the map has {n} rows and {k} columns", 8.0 * n * k)
        E, worst = np.empty((n, k)), 0.0
        for where, some in self.respond.columns():
            E[:, where], worst = some.values, max(worst, some.error)
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

    @cached_property
    def _squares(self) -> Squares:
        """|E_row|²."""
        if self.probes:
            return self.respond.squares(self.probing)
        return Squares.exact(np.sum(self.matrix**2, axis=1))

    @property
    def gain(self) -> Estimate:
        """K, a length (a number for a covariance): E_rms = K κ ξ/⟨|f|⟩."""
        return self._squares.root_mean()

    @property
    def covariance(self) -> Floats:
        """(2c, 2c): times (κ ξ)², the covariance of the forces."""
        return self.matrix @ self.matrix.T

    @property
    def per_component(self) -> Floats:
        """(2c,) standard deviation of f_n then f_t, over κ ξ."""
        return self.component_errors.values

    @property
    def component_errors(self) -> Estimates:
        """`per_component`, with error bars of its own."""
        return self._squares.rows.root()

    @property
    def per_contact(self) -> Floats:
        """(c,) √(δf_n² + δf_t²), over κ ξ."""
        return self.contact_errors.values

    @property
    def contact_errors(self) -> Estimates:
        """`per_contact`, with error bars of its own, as if f_n and f_t were off the same way."""
        rows = self._squares.rows
        values, error = (
            x.reshape(-1, self.contacts).sum(axis=0) for x in (rows.values, rows.error)
        )
        return Estimates(values, error, rows.probes).root()

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
