"""Least squares with equality constraints, sparse: min |A u - a| subject to B u = b.

Method of multipliers on the residuals, with one factorisation of H = AᵀA + w BᵀB:

    H d = Aᵀ(a - A u) - Bᵀλ + w Bᵀ(b - B u) ,    u ← u + d ,    λ ← λ + w (B u - b)

A step shrinks the violation in a direction where B has the singular value s (relative to A) by
1/(1 + w s²), so with w = 1e7 three or four reach rounding; if twelve do not, because s is small,
w rises. It is indifferent to redundant rows
of B, as the balance of the whole among the balances of all grains, and where B u = b has no
solution (more conditions than unknowns, met up to rounding) it converges to the least
violation: the limit of noise in b that is far below all other noise.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import pinv, svd
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from packing.arrays import Floats

if TYPE_CHECKING:
    from scaling.network import ContactNetwork

WEIGHTS = (1e7, 1e9, 1e11, 1e13)
_CREEP = 1e-4
"""What may still move at the end: directions that B sees with s < 1e-6 only, such as the noise of
positions known 1e6 times better than sizes. Its effect on forces is smaller by as much."""
_VIOLATION = 1e-8
"""What may be left of the conditions, relative to the data: above rounding, far below noise."""
DENSE_UP_TO = 2500
"""Unknowns and conditions up to which a failed iteration is replaced by a decomposition."""
_STEPS = 12  # with each weight; the rounding of a step is ~1e-16 w, and is corrected by the next


class ConstrainedLeastSquares:
    """min |A u - a| subject to B u = b, prepared once for any number of right-hand sides.

    A and B should have entries of order 1, and null spaces that meet in 0 only.
    """

    def __init__(self, A: csr_array, B: csr_array, name: str) -> None:
        self.A, self.B, self.name = csr_array(A), csr_array(B), name

    def __getstate__(self) -> dict[str, Any]:
        # SuperLU objects cannot be pickled; a copy factorises anew.
        return {k: v for k, v in self.__dict__.items() if k != "_factors"}

    @cached_property
    def _factors(self) -> dict[float, Any]:
        return {}

    def _factor(self, weight: float) -> Any:
        if weight not in self._factors:
            self._factors[weight] = self._factorised(weight)
        return self._factors[weight]

    def _factorised(self, weight: float) -> Any:
        H = csc_array(self.A.T @ self.A + weight * (self.B.T @ self.B))
        return splu(
            H,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def solve(self, a: Floats, b: Floats) -> Floats:
        """u, (n,) for a (p,) and b (m,), or (n, k) for (p, k) and (m, k).

        RuntimeError if the corrections do not die out, or the conditions are not met.
        """
        u = self._solve(a, b)
        # Of conditions that contradict each other the least violation is left: Bᵀ(B u - b) = 0.
        scale = self._size * float(np.linalg.norm(a) + np.linalg.norm(b))
        violation = float(np.linalg.norm(self.B.T @ (self.B @ u - b)))
        if not violation <= _VIOLATION * scale:
            raise RuntimeError(
                f"{self.name}: the constraints are violated by {violation / scale:.1e}, relative: "
                "its rows and weights are of very different size"
            )
        return u

    @cached_property
    def _size(self) -> float:
        """|B|, the largest norm of a column: of the order of its largest singular value."""
        return float(np.sqrt(self.B.multiply(self.B).sum(axis=0).max()))

    def _solve(self, a: Floats, b: Floats) -> Floats:
        A, B = self.A, self.B
        u = np.zeros((A.shape[1], *a.shape[1:]))
        λ = np.zeros_like(b)
        previous, given = np.inf, float(np.linalg.norm(a) + np.linalg.norm(b))
        for w in np.repeat(WEIGHTS, _STEPS):
            d = self._factor(w).solve(A.T @ (a - A @ u) - B.T @ λ + w * (B.T @ (b - B @ u)))
            u = u + d
            λ = λ + w * (B @ u - b)
            size, scale = float(np.linalg.norm(d)), float(np.linalg.norm(u)) + given
            # Done when the correction is rounding, or no longer shrinks because it is.
            if size <= 4e-16 * scale or (size <= 1e-9 * scale and size > 0.5 * previous):
                return u
            previous = size
        if size <= _CREEP * scale:
            return u
        if max(A.shape[1], B.shape[0]) <= DENSE_UP_TO:
            return self._dense(a, b)
        raise RuntimeError(
            f"{self.name}: corrections are still {size / scale:.1e} with all weights, "
            "the constraints are nearly dependent"
        )

    @cached_property
    def _null_space(self) -> tuple[Floats, Floats, Floats]:
        """B⁺, a basis Z of the null space of B, and (A Z)⁺."""
        U, s, Vt = svd(self.B.toarray())
        rank = int((s > 1e-13 * s[0]).sum())
        Z = Vt[rank:].T
        return (Vt[:rank].T / s[:rank]) @ U[:, :rank].T, Z, pinv(self.A @ Z)

    def _dense(self, a: Floats, b: Floats) -> Floats:
        """u = B⁺ b + Z (A Z)⁺ (a - A B⁺ b): for noise of very different strengths."""
        inverse, Z, of_rest = self._null_space
        u = inverse @ b
        return u + Z @ (of_rest @ (a - self.A @ u))


def global_moments(network: ContactNetwork) -> csr_array:
    """(3N, parts): the rows of M combined to the moment of each part of an open component.

    Internal forces balance in it up to O(Δ) only (lever arms R_i at contacts that overlap):
    enforced on noisy directions it would amplify their noise by 1/Δ, so estimators leave it
    free. A bridge, a contact on no loop, cannot transmit moment either, so the parts that bridges
    join (a dangling grain, say) are counted one by one. None for what winds a periodic cell,
    and none if only directions are known.
    """
    active, forest = network.active, network.forest
    none = csr_array((3 * len(active), 0))
    if network.positions is None:
        return none
    looped = np.diff(csc_array(network.loops.incidence).indptr) > 0
    winds = forest.winding_rank[forest.component] > 0
    i, j = network.pairs[looped | winds[network.pairs[:, 0]]].T
    graph = csr_array((np.ones(len(i)), (i, j)), shape=(network.grains, network.grains))
    component = connected_components(graph, directed=False)[1][active]
    labels = np.unique(component[~winds[active]])
    x = network.positions[active]
    if network.cell is not None:
        x = x + forest.shift[active] @ network.cell
    columns = []
    for label in labels:
        mine = component == label
        y = np.where(mine[:, None], x - x[mine].mean(axis=0), 0.0)
        v = np.concatenate([-y[:, 1], y[:, 0], np.where(mine, network.radii[active], 0.0)])
        columns.append(v / np.linalg.norm(v))
    return csr_array(np.column_stack(columns)) if columns else none
