"""How many conditions the noise has to meet in `bounded`: the degrees of freedom of its misfit.

    d = tr A ,    A the block of η in P

η are the sources of noise, as standard normals. The prior counts as noise of the forces, and P
is the projection of both noises on the conditions. A itself is no projection: forces may give
way to a condition, and then less of η is found. Where the noise is strong, only balance says
what η is.

Bounds that are met with equality are conditions too. With all of them tr A is the mean of |η|²
or above it. Without them tr A², the mean for fixed forces, is the mean of |η|² or below it. The
misfit is |η|²/tr A. The noise counts as weaker than told only if |η|² is improbably small for
tr A².
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_array, csc_array, csr_array, diags_array, eye_array, vstack
from scipy.sparse.linalg import SuperLU, splu

from packing.arguments.arrays import Floats, Integers
from scaling.algebra.elimination import COLUMNS, Factor
from scaling.estimators.bounded.barrier.condensed import Blocks, Condensed
from scaling.estimators.bounded.barrier.interior_point import FAINT, prepared_for
from scaling.estimators.bounded.order import Sites, elimination_order
from scaling.estimators.bounded.program import Program
from scaling.estimators.misfit import Misfit

EXACT_UP_TO = 128
"""Sources of noise up to which a trace is summed, not sampled."""
_PROBES = 64
_ACTIVE = 1e-6
"""Distance from a bound, in f̄, below which it counts as met with equality."""
_HELD = 1e10
"""Weight of a bound that is met with equality, where prior forces have the weight 1."""
_SHIFT = 1e-12
ACCURATE = 1e-8
"""What a solve without pivoting may leave of the right-hand side: far less than probes scatter."""
REFINEMENTS = 2
"""Solves of what is left: at 1e5 grains one brings 3e-7 to 1e-10, where pivoting takes 5 GB."""


def misfit_of_bounded(task: Program, z: Floats) -> Misfit:
    """Of `scaling.estimators.bounded.bounded`: at the solution z of its program."""
    η = task.noise(z)
    met = np.flatnonzero(task.cone @ z > -_ACTIVE)
    prepared = prepared_for(task)
    if prepared is not None:
        free, (most, _) = _condensed_traces(*prepared, met)
    else:
        free = _traces(task, met[:0])
        most = _traces(task, met)[0] if len(met) else free[0]
    return Misfit(float(η @ η), most, free[1])


def _traces(task: Program, met: Integers) -> tuple[float, float]:
    """tr P and tr P² of the block of η, P the projection on all conditions, the bounds `met`
    among them."""
    n, k = task.unknowns, task.sources
    probes, weight = _probes(k)
    E, P = csr_array(vstack([task.equal, task.cone[met]])), task.P.copy()
    # Weak noise: forces in units of their own scatter, so that noise and forces weigh alike.
    effect = E[:, n : n + k]
    strength = min(1.0, float(np.sqrt(effect.multiply(effect).sum() / max(k, 1))) or 1.0)
    unit = np.ones(len(P))
    unit[:n] = strength
    E = csr_array(E @ diags_array(unit))
    P = P * unit**2
    length = np.sqrt(np.asarray(E.multiply(E).sum(axis=1)).ravel())
    E = csr_array(diags_array(1 / np.where(length > 0, length, 1.0)) @ E)
    lower = -_SHIFT * eye_array(E.shape[0])
    P = np.where(P == 0, _SHIFT, P)
    K = csc_array(block_array([[diags_array(P), E.T], [E, lower]]))
    root = np.sqrt(P[n : n + k])[:, None]
    right = np.zeros((K.shape[0], probes.shape[1]))
    right[n : n + k] = root * probes
    kept = probes - root * _solved(K, right, _order(task, met))[n : n + k]
    return _traces_of(kept, probes, weight)


def _probes(sources: int) -> tuple[Floats, float]:
    """Unit vectors, or random signs, (k, columns), and the weight of each in a trace."""
    if sources <= EXACT_UP_TO:
        return np.eye(sources), 1.0
    signs = np.random.default_rng(0).integers(0, 2, (sources, _PROBES))
    return np.where(signs, 1.0, -1.0), 1 / _PROBES


def _traces_of(kept: Floats, probes: Floats, weight: float) -> tuple[float, float]:
    """tr P and tr P², of P times the probes."""
    return weight * float(np.sum(probes * kept)), weight * float(np.sum(kept**2))


def _condensed_traces(blocks: Blocks, sites: Sites, met: Integers) -> list[tuple[float, float]]:
    """`_traces` without bounds, and with those that are met."""
    k, m, made, traces = blocks.X.shape[1], len(blocks.b), None, []
    probes, weight = _probes(k)
    root = np.sqrt(blocks.P[blocks.noise])[:, None]
    held = (FAINT * np.ones(blocks.contacts)).ravel()
    for some in (met[:0], met):
        held[some] = _HELD
        μ = blocks.task.posterior.friction
        made = Condensed(blocks, sites, held.reshape(2, -1), μ, made)
        kept = probes.copy()
        for start in range(0, probes.shape[1], COLUMNS):
            mine = slice(start, start + COLUMNS)
            right = root * probes[:, mine]
            top = np.vstack([right, np.zeros((m, right.shape[1]))])
            bottom = np.zeros((len(made.corner), right.shape[1]))
            kept[:, mine] -= root * made.solve(top, bottom, 1)[0][:k]
        traces.append(_traces_of(kept, probes, weight))
    return traces


def _order(task: Program, met: Integers) -> Integers | None:
    contacts = task.posterior.equation.network.contacts
    return elimination_order(task.posterior, len(task.P), len(task.b), met % contacts)


def _solved(K: csc_array, right: Floats, order: Integers | None) -> Floats:
    """K⁻¹ of the columns of `right`: pivoted where no order is known, or the order is not good."""
    lu = None if order is None else _unpivoted(csc_array(K[order][:, order]))
    if order is not None and lu is not None:
        factor, found = Factor(lu, order), np.zeros_like(right)
        for _ in range(1 + REFINEMENTS):
            found += factor.solve(right - K @ found)
            if np.abs(K @ found - right).max(initial=0.0) <= ACCURATE * np.abs(right).max():
                return found
    return splu(K).solve(right)


def _unpivoted(K: csc_array) -> SuperLU | None:
    """Factors in this order; None where a redundant condition leaves a pivot of exactly 0."""
    try:
        return splu(
            K, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        return None
