"""One linear system of the barrier method for `bounded`, with forces eliminated:

    [ G   Cᵀ ] (v ; λ) = ... ,    G = P_v + Xᵀ a X ,    C = T - N X ,    S = M_t h M_tᵀ
    [ C  -S  ]

for the noise v = g η, and the multipliers λ of balance, M φ + T v = b; φ_n = d - X v are the data.
The limits r = ±φ_t - μ φ_n of a contact cost ν r + w r²/2. Then

    φ_t = s φ_n - h (q_t + m_t·λ) ,    h = 1/(p_t + w₁ + w₂) ,    s = h μ (w₁ - w₂)

h = b² and s = 0 where it sticks; h -> 0 and s -> ±μ where it slides, w -> ∞. It bears the column
N = M_n + s M_t, and a is the precision of φ_n. So 5 unknowns of a grain are left, and they meet
those of neighbours only: see `scaling.algebra.fronts`. What meets all of them (the rows of a
stress that is told, free moments) borders this matrix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array, eye_array, hstack, vstack

from packing.arguments.arrays import Floats
from scaling.algebra.fronts.signed_cholesky import SignedCholesky
from scaling.estimators.bounded.order import Sites
from scaling.estimators.bounded.program import Program

_SHIFT = 1e-12
"""Keeps redundant balances apart; refined away."""
_ACCURATE, ROUNDS = 1e-12, 4
"""What refinement may leave of a row, relative to its right-hand side, or to 1, and its rounds."""


class Blocks:
    """The blocks of a program by contacts, noise and what meets all."""

    def __init__(self, task: Program) -> None:
        E, n, k, rows = csr_array(task.equal), task.unknowns, task.sources, task.explicit
        c, m = n // 2, rows.start
        self.task, self.contacts, self.noise = task, c, slice(n, n + k)
        self.M_n, self.M_t = csr_array(E[:m, :c]), csr_array(E[:m, c:n])
        self.T, self.X = csr_array(E[:m, n : n + k]), csr_array(E[rows, n : n + k])
        self.beside = csr_array(E[rows, n + k :]).count_nonzero()
        told = E[rows.stop :].toarray()
        self.R_n, self.R_t, self.R_v = told[:, :c], told[:, c:n], told[:, n : n + k]
        self.R_w, self.V = told[:, n + k :], E[:m, n + k :].toarray()
        self.b, self.d, self.s = np.split(task.b, [m, rows.stop])
        self.P, self.q = task.P, task.q


@dataclass(frozen=True, eq=False)
class Point:
    """φ_n, φ_t, v, w, and the multipliers of balance λ and of what is told τ."""

    φ_n: Floats
    φ_t: Floats
    v: Floats
    w: Floats
    λ: Floats
    τ: Floats

    @property
    def z(self) -> Floats:
        """Of the program."""
        return np.concatenate([self.φ_n, self.φ_t, self.v, self.w])

    def beyond(self, μ: float) -> Floats:
        """r (2, c), by how much the limits of f_t > 0 and f_t < 0 are passed."""
        return np.array([self.φ_t, -self.φ_t]) - μ * self.φ_n

    def towards(self, other: Point, share: float) -> Point:
        """So far on the way to `other`."""
        return Point(*(
            mine + share * (getattr(other, name) - mine) for name, mine in vars(self).items()
        ))  # fmt: skip


class Condensed:
    """The matrix for the weights w (2, c) of the limits, in factors.

    `instead`: that of other weights, which is not needed any more.
    """

    def __init__(
        self,
        blocks: Blocks,
        sites: Sites,
        weights: Floats,
        friction: float,
        instead: Condensed | None = None,
    ) -> None:
        B, c = blocks, blocks.contacts
        p_n, p_t, both = B.P[:c], B.P[c : 2 * c], weights.sum(axis=0)
        self.h = 1 / (p_t + both)
        self.slope = slope = self.h * friction * (weights[0] - weights[1])
        self.a = p_n + friction**2 * self.h * (p_t * both + 4 * weights[0] * weights[1])
        self.blocks, self.μ = blocks, friction
        self.N = csr_array(B.M_n + B.M_t @ diags_array(slope))
        self.R = B.R_n + B.R_t * slope
        G = csr_array(diags_array(B.P[B.noise]) + B.X.T @ diags_array(self.a) @ B.X)
        C = csr_array(B.T - self.N @ B.X)
        S = csr_array(B.M_t @ diags_array(self.h) @ B.M_t.T)
        k, m = B.X.shape[1], len(B.b)
        rows = [[G, csr_array(C.T)], [C, -S - _SHIFT * eye_array(m)]]
        self.K = csr_array(vstack([hstack(row, format="csr") for row in rows], format="csr"))
        # As it is symmetric, its rows are its columns.
        shifted = csc_array(self.K.T)
        site = np.concatenate([sites.sources, sites.balances])
        signs = np.repeat([1.0, -1.0], [k, m])
        if instead is not None and instead.factor.update(shifted):
            self.factor: SignedCholesky = instead.factor
        else:
            self.factor = SignedCholesky(shifted, site, sites.starts, signs, again=True)
        # Borders: w, then τ.
        of_told = np.vstack([(B.R_v - (B.X.T @ self.R.T).T).T, -(B.M_t @ (self.h * B.R_t).T)])
        self.border = np.hstack([np.vstack([np.zeros((k, B.V.shape[1])), B.V]), of_told])
        P_w = np.diag(B.P[B.noise.stop :])
        self.corner = np.block([[P_w, B.R_w.T], [B.R_w, -(B.R_t * self.h) @ B.R_t.T]])
        self.seen = self.factor.solve(self.border)
        self.left = self.corner - self.border.T @ self.seen

    def _once(self, top: Floats, bottom: Floats) -> tuple[Floats, Floats]:
        x = self.factor.solve(top)
        if not len(bottom):
            return x, bottom
        y = np.asarray(np.linalg.solve(self.left, bottom - self.border.T @ x), float)
        return x - self.seen @ y, y

    def solve(self, top: Floats, bottom: Floats, rounds: int = ROUNDS) -> tuple[Floats, Floats]:
        """(v ; λ), (w ; τ) for one right-hand side or many, refined in so many rounds at most."""
        x, y = self._once(top, bottom)
        k = self.blocks.X.shape[1]
        sizes, left = (np.maximum(1.0, abs(top)), np.maximum(1.0, abs(bottom))), np.inf
        for _ in range(rounds):
            off = top - self.K @ x - self.border @ y
            off[k:] -= _SHIFT * x[k:]
            beside = bottom - self.border.T @ x - self.corner @ y
            parts = zip((off, beside), sizes, strict=True)
            before, left = left, max((abs(p) / size).max(initial=0.0) for p, size in parts)
            if left <= _ACCURATE or left > 0.5 * before:
                break
            dx, dy = self._once(off, beside)
            x, y = x + dx, y + dy
        return x, y

    def point(self, ν: Floats, rounds: int = ROUNDS) -> Point:
        """The least cost for multipliers ν (2, c)."""
        B, c = self.blocks, self.blocks.contacts
        k, rest = B.X.shape[1], B.V.shape[1]
        q_n, q_t = B.q[:c] - self.μ * ν.sum(axis=0), B.q[c : 2 * c] + ν[0] - ν[1]
        inside = B.b - self.N @ B.d + B.M_t @ (self.h * q_t)
        bottom = np.concatenate([-B.q[B.noise.stop :],
                                 B.s - self.R @ B.d + B.R_t @ (self.h * q_t)])  # fmt: skip
        cost = self.a * B.d + q_n + self.slope * q_t
        x, y = self.solve(np.concatenate([B.X.T @ cost, inside]), bottom, rounds)
        v, λ, w, τ = x[:k], x[k:], y[:rest], y[rest:]
        φ_n = B.d - B.X @ v
        φ_t = self.slope * φ_n - self.h * (q_t + B.M_t.T @ λ + B.R_t.T @ τ)
        return Point(φ_n, φ_t, v, w, λ, τ)
