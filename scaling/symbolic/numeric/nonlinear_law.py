"""GPPSZ's reconstruction for a nonlinear contact law, by Newton's method.

    min |M f̂ + F̂|² + |Q y - (Qσ - Λ)/Δ|²,        f̂_n = sign(y)|y|^α,   y = δ/Δ

over overlaps y and transverse forces.  Noise makes overlaps negative, hence the odd
continuation; y rather than f̂ is the unknown because |f̂|^(1/α) has an infinite slope at f̂ = 0
for α > 1 and |y|^α has not.  The minimum is the same.  Forces in units of p⟨σ⟩.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packing.arguments.arrays import real_array
from packing.arguments.numbers import number_between, positive_number, whole_number
from scaling.symbolic.numeric import lambdify

Array = NDArray[np.float64]


class NotConverged(ValueError):
    """Newton's method stopped short; carries the step reached."""


def linearised(M: Array, Q: Array, overlaps: Array, exponent: float) -> Array:
    """Jacobian [M_n α|y|^(α-1), M_t; Q, 0] of the residual at overlaps y (in Δ)."""
    M, Q, c = _matrices(M, Q)
    overlaps = real_array("overlaps", overlaps, (c,), "contact")
    top = M.copy()
    top[:, :c] *= lambdify.law(exponent)[1](overlaps)
    bottom = np.hstack([Q, np.zeros((Q.shape[0], M.shape[1] - c))])
    return np.vstack([top, bottom])


def response(M: Array, Q: Array, forces: Array, exponent: float) -> Array:
    """Linear response of f̂ to data Q δσ/Δ at true forces f̂ > 0, shape (unknowns, c).

    Newton's linearisation of closure, Q(f̂^(1/α - 1)/α δf̂) = Q δσ/Δ, solved with M δf̂ = 0.
    """
    M, Q, c = _matrices(M, Q)
    exponent = number_between("exponent", exponent, 1e-3, 100)
    forces = real_array("forces", forces, None, "component")
    if forces.ndim != 1 or forces.size < c:
        raise ValueError(f"forces has shape {forces.shape}, expected ({M.shape[1]},) or ({c},)")
    if (forces[:c] <= 0).any():
        raise ValueError(f"contact {int(np.argmin(forces[:c]))} carries no compressive force")
    compliance = 1 / (exponent * forces[:c] ** (1 - 1 / exponent))
    bottom = np.hstack([Q * compliance, np.zeros((Q.shape[0], M.shape[1] - c))])
    plus = np.linalg.pinv(np.vstack([M, bottom]))
    return plus[:, M.shape[0] :] @ Q


def reconstruct(
    M: Array,
    Q: Array,
    loads: Array,
    gaps: Array,
    exponent: float,
    start: Array,
    *,
    steps: int = 200,
    tolerance: float = 1e-11,
) -> Array:
    """f̂ from balance (M f̂ = -loads) and closure data gaps = (Qσ - Λ)/Δ.

    `start` (unknowns,): forces to start from, not zero.  Gauss-Newton with step halving until
    the step is below `tolerance` relative to y; NotConverged after `steps`.
    """
    M, Q, c = _matrices(M, Q)
    loads = real_array("loads", loads, (M.shape[0],), "row")
    gaps = real_array("gaps", gaps, (Q.shape[0],), "row")
    start = real_array("start", start, (M.shape[1],), "component")
    steps, tolerance = whole_number("steps", steps, 1), positive_number("tolerance", tolerance)
    force, _ = lambdify.law(exponent)
    y = np.sign(start[:c]) * np.abs(start[:c]) ** (1 / exponent)
    x = np.concatenate([y, start[c:]])

    def residual(x: Array) -> Array:
        f = np.concatenate([force(x[:c]), x[c:]])
        return np.concatenate([M @ f + loads, Q @ x[:c] - gaps])

    now = residual(x)
    for _ in range(steps):
        step = np.linalg.lstsq(linearised(M, Q, x[:c], exponent), -now, rcond=None)[0]
        fraction = 1.0
        while fraction > 1e-6:
            new = residual(x + fraction * step)
            if new @ new <= now @ now:
                break
            fraction /= 2
        else:
            return np.concatenate([force(x[:c]), x[c:]])  # no descent left: at the minimum
        x, now = x + fraction * step, new
        if np.linalg.norm(step) < tolerance * np.linalg.norm(x):
            return np.concatenate([force(x[:c]), x[c:]])
    raise NotConverged(f"after {steps} steps the last step is {np.linalg.norm(step):.1e}")


def _matrices(M: Array, Q: Array) -> tuple[Array, Array, int]:
    """M, Q and the number of contacts."""
    M, Q = real_array("M", M, (None, None), "row"), real_array("Q", Q, (None, None), "row")
    c = Q.shape[1]
    if c == 0 or M.shape[1] not in (c, 2 * c):
        raise ValueError(f"M has {M.shape[1]} columns and Q {c}: expected as many, or twice")
    return M, Q, c
