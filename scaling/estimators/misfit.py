"""Is the noise found in the data the noise that was told?

Estimates that weigh noise assume y = ξ η, η standard normals, and find the most probable η that
leaves a packing in balance.  For data made by that noise |η|² is χ² of as many degrees of
freedom as there are conditions that the noise alone has to meet,

    optimal    d = rank [C, -M_t] - rank M_t        data="all"
               d = rank [0, M ; Q B, (Q, 0)] - rank G     data="sizes"

since η is then the projection of the true one on d directions.  misfit = |η|²/d has mean 1 and
variance 2/d: much above, the noise is stronger than told, or data or balance are wrong; much
below, weaker.  d is counted, per component: balances less those met whatever the noise (two
translations; moments are left free), less transverse forces, at most the sizes that enter.  Small
problems are decomposed.

    bounded    d = tr P ,    P the projection on the conditions, of the block of η

where the prior is noise of the forces, so P is no projection within η: strong noise is told by
balance alone, and what the forces give way to leaves η short.  Bounds that are met with equality
are conditions too.  With all of them, tr P is the mean of |η|² or above it; without them,
tr P² of the forces fixed is the mean or below it.  misfit refers to the first; too small is
only what is improbable for the second.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import svdvals
from scipy.sparse import block_array, csc_array, csr_array, diags_array, eye_array, hstack, vstack
from scipy.sparse.linalg import splu
from scipy.special import gammainc, gammaincc

from packing.arguments.arrays import Floats, Integers
from packing.arguments.callers import outside
from scaling.equation.force_equation import ForceEquation
from scaling.equation.global_moments import global_moments
from scaling.estimators.bounded.program import Programme
from scaling.noise.noise_model import Sources

IMPROBABLE = 1e-6
"""Two-sided tail of χ² below which noise is called implausible."""
DENSE_UP_TO = 300
"""Conditions up to which ranks are those of a decomposition."""
EXACT_UP_TO = 128
"""Sources of noise up to which a trace is summed, not sampled."""
_PROBES = 64
_RANK = 1e-10
_ACTIVE = 1e-6
"""Distance from a bound, in f̄, below which it counts as met with equality."""
_SHIFT = 1e-12


class ImplausibleNoiseWarning(UserWarning):
    """The noise found in the data is not of the strength that was told."""


@dataclass(frozen=True)
class Misfit:
    """|η|² of the noise found, and the degrees of freedom that it should have, most and least."""

    square: float
    most: float
    least: float

    @property
    def value(self) -> float | None:
        """χ² per degree of freedom; None if nothing is left over to judge the noise by."""
        return self.square / self.most if self.most > 0 else None

    @property
    def tail(self) -> float:
        """The two-sided probability of noise as far from what was told."""
        if self.most <= 0:
            return 1.0
        above = gammaincc(self.most / 2, self.square / 2)
        below = gammainc(self.least / 2, self.square / 2) if self.least > 0 else 1.0
        return float(min(1.0, 2 * min(above, below)))


def warn_if_implausible(misfit: Misfit, told: str) -> None:
    """ImplausibleNoiseWarning if the tail of χ² is below 1e-6."""
    if misfit.value is None or misfit.tail >= IMPROBABLE:
        return
    times = np.sqrt(misfit.value)
    if misfit.square > misfit.most:
        cause = (
            "the noise is stronger than told, or sizes, contacts, loads or friction are wrong, "
            "or positions are rounded"
        )
    else:
        cause = "the noise is weaker than told, or the data are exact"
    warnings.warn(
        f"the data ask for {times:.2g} times the noise that was told ({told}): χ² per degree of "
        f"freedom is {misfit.value:.3g} with {misfit.most:.0f} of them, probability "
        f"{misfit.tail:.0e}. Likely cause: {cause}",
        ImplausibleNoiseWarning,
        stacklevel=outside(),
    )


# --- optimal ------------------------------------------------------------------------------


def misfit_of_optimal(
    equation: ForceEquation, noise: Sources, η: Floats, φ: Floats, data: str
) -> Misfit:
    """Of `scaling.estimators.optimal`: η (k,) found, at the lengths φ = f/κ."""
    d = float(conditions_on_noise(equation, noise, φ, data))
    return Misfit(float(η @ η), d, d)


def conditions_on_noise(equation: ForceEquation, noise: Sources, φ: Floats, data: str) -> int:
    """d, the number of independent conditions that the noise alone has to meet."""
    acting, free = _conditions(equation, noise, φ, data)
    if acting.shape[0] <= DENSE_UP_TO:
        every = np.hstack([_scaled(acting).toarray(), free.toarray()])
        return _rank(every) - _rank(free.toarray())
    return _counted(equation, noise, acting, free, data)


def _conditions(
    equation: ForceEquation, noise: Sources, φ: Floats, data: str
) -> tuple[csr_array, csr_array]:
    """Columns of the conditions for the noise, and for what is free."""
    matrices, network = equation.matrices, equation.network
    B = noise.overlaps(network)
    if data == "sizes":
        none = csr_array((equation.M.shape[0], noise.count))
        return csr_array(vstack([none, matrices.Q @ B])), matrices.G
    acting = csr_array(matrices.M_normal @ B + noise.balance(network, φ))
    if not equation.frictional:
        return acting, csr_array((acting.shape[0], 0))
    return acting, csr_array(hstack([matrices.M_tangential, global_moments(network)]))


def _scaled(columns: csr_array) -> csr_array:
    """With columns of length 1: noise of mixed strengths counts alike."""
    length = np.sqrt(np.asarray(columns.multiply(columns).sum(axis=0)).ravel())
    return csr_array(columns @ diags_array(1 / np.where(length > 0, length, 1.0)))


def _rank(matrix: Floats) -> int:
    if 0 in matrix.shape:
        return 0
    s = svdvals(matrix)
    return int((s > _RANK * s[0]).sum())


def _counted(
    equation: ForceEquation, noise: Sources, acting: csr_array, free: csr_array, data: str
) -> int:
    """d of a disordered network: the conditions left over, or the sources, if they are fewer."""
    network, forest = equation.network, equation.network.forest
    labels, part = np.unique(forest.component[network.active], return_inverse=True)
    count, winding = len(labels), forest.winding_rank[labels]
    of_contact = np.searchsorted(labels, forest.component[network.pairs[:, 0]])
    c = np.bincount(of_contact, minlength=count)
    balances = (3 if equation.frictional else 2) * np.bincount(part, minlength=count) - 2
    moments = np.zeros(count, dtype=np.int64)
    if equation.frictional:
        columns = csc_array(global_moments(network))
        grain = columns.indices[columns.indptr[:-1]] % len(network.active)
        moments = np.bincount(part[grain], minlength=count)
    elif not noise.moves:
        moments = (winding == 0).astype(np.int64)  # met by normal forces, whatever they are
    if data == "sizes":
        loops = csc_array(network.loops.incidence.T)
        first = loops.indices[loops.indptr[:-1]]
        faces = np.bincount(of_contact[first], minlength=count)
        # The faces of a torus add up to 0, and f_n ∝ r closes all loops.
        closures = np.minimum(2 * faces - 2 * (winding == 2), c - 1)
        # Of several moments, joined by bridges, the one of the whole is not exactly 0.
        exact = moments - (moments > 0) if equation.frictional else moments
        left = balances - exact + closures - (2 if equation.frictional else 1) * c
    else:
        left = balances - moments - (c if equation.frictional else 0)
    sources = np.bincount(
        _component_of_source(equation, acting, part, of_contact), minlength=count
    )
    if data == "sizes":
        # Without loads, sizes and forces may grow by one factor.
        loaded = network.external[network.active].any(axis=1)
        sources = sources - (np.bincount(part[loaded], minlength=count) == 0)
    return int(np.minimum(left, sources).sum())


def _component_of_source(
    equation: ForceEquation, acting: csr_array, part: Integers, of_contact: Integers
) -> Integers:
    """The component on which each source acts that acts on any: by the first row that feels it."""
    columns = csc_array(acting)
    columns.eliminate_zeros()
    columns.sort_indices()
    row = columns.indices[columns.indptr[:-1][np.diff(columns.indptr) > 0]]
    balances, loops = equation.M.shape[0], equation.matrices.loops
    if acting.shape[0] == balances:
        return part[row % len(equation.network.active)]
    incidence = csr_array(loops.incidence)
    first = incidence.indices[incidence.indptr[(row - balances) % len(loops)]]
    return of_contact[first]


# --- bounded ------------------------------------------------------------------------------


def misfit_of_bounded(task: Programme, z: Floats) -> Misfit:
    """Of `scaling.estimators.bounded.bounded`: at the solution z of its programme."""
    η = task.noise(z)
    met = np.flatnonzero(task.cone @ z > -_ACTIVE)
    free = _traces(task, task.cone[:0])
    most = _traces(task, task.cone[met])[0] if len(met) else free[0]
    return Misfit(float(η @ η), most, free[1])


def _traces(task: Programme, met: Any) -> tuple[float, float]:
    """tr P and tr P² of the block of η, P the projection on all conditions, `met` among them."""
    n, k = task.unknowns, task.sources
    E, P = csr_array(vstack([task.equal, met])), task.P.copy()
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
    factor = splu(csc_array(block_array([[diags_array(P), E.T], [E, lower]])))
    root = np.sqrt(P[n : n + k])[:, None]
    probes: Floats = np.eye(k)
    weight = 1.0
    if k > EXACT_UP_TO:
        signs = np.random.default_rng(0).integers(0, 2, (k, _PROBES))
        probes, weight = np.where(signs, 1.0, -1.0), 1 / _PROBES
    right = np.zeros((factor.shape[0], probes.shape[1]))
    right[n : n + k] = root * probes
    kept = probes - root * factor.solve(right)[n : n + k]
    return weight * float(np.sum(probes * kept)), weight * float(np.sum(kept**2))
