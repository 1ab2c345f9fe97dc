"""How many conditions the noise alone has to meet in `optimal`: the freedom of its misfit.

    d = rank [C, -M_t] - rank M_t              data="all"
    d = rank [0, M ; Q B, (Q, 0)] - rank G     data="sizes"

C, B and M_t are those of `scaling.estimators.optimal.least_noise`. The η found is the
projection of the true one on d directions.

Small problems are decomposed. In large ones d is counted, for each connected component: it is
the number of balances, less those that are met whatever the noise (two translations; moments
are left free), less that of transverse forces. It is at most the number of sources that act.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.linalg import svdvals
from scipy.sparse import csc_array, csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats, Integers
from scaling.equation.force_equation import ForceEquation
from scaling.equation.global_moments import moments_left_free
from scaling.equation.trivial_balances import trivial_balances
from scaling.estimators.misfit import Misfit
from scaling.estimators.optimal.load_conditions import load_columns
from scaling.estimators.told.mean_stress import MeanStress
from scaling.geometry.bodies import held_components
from scaling.noise.noise_model import NoiseModel


class Asked(Protocol):
    """The options that matter here."""

    @property
    def data(self) -> str:
        """ "all", or "sizes"."""

    @property
    def told(self) -> MeanStress:
        """Of the mean stress."""


DENSE_UP_TO = 300
"""Conditions up to which ranks are those of a decomposition."""
_RANK = 1e-10


def misfit_of_optimal(
    equation: ForceEquation, noise: NoiseModel, η: Floats, φ: Floats, asked: Asked
) -> Misfit:
    """Of `scaling.estimators.optimal.optimal`: η (k,) found, at the lengths φ = f/κ."""
    alone = conditions_on_noise(equation, noise, φ, asked.data)
    # Each stress told is one condition more, as far as there is noise to meet it.
    d = float(min(alone + len(asked.told.data), max(alone, noise.count)))
    return Misfit(float(η @ η), d, d)


def conditions_on_noise(equation: ForceEquation, noise: NoiseModel, φ: Floats, data: str) -> int:
    """d, the number of independent conditions that the noise alone has to meet."""
    acting, free = acting_and_free(equation, noise, φ, data)
    if acting.shape[0] <= DENSE_UP_TO:
        every = np.hstack([scaled(acting).toarray(), free.toarray()])
        return _rank(every) - _rank(free.toarray())
    return _counted(equation, noise, acting, data) + _of_loads(equation, noise)


def acting_and_free(
    equation: ForceEquation, noise: NoiseModel, φ: Floats, data: str
) -> tuple[csr_array, csr_array]:
    """Columns of the conditions for the noise, and for what is free."""
    matrices, network = equation.matrices, equation.network
    B = noise.overlaps(network)
    if data == "sizes":
        return csr_array(vstack([-load_columns(equation, noise), matrices.Q @ B])), matrices.G
    acting = matrices.M_normal @ equation.stiffened(B) + noise.balance(network, φ)
    acting = csr_array(acting + load_columns(equation, noise))
    if not equation.frictional:
        return acting, csr_array((acting.shape[0], 0))
    free = moments_left_free(equation, noise.loads)
    return acting, csr_array(hstack([matrices.M_tangential, free]))


def scaled(columns: csr_array) -> csr_array:
    """With columns of length 1: noise of mixed strengths counts alike."""
    length = np.sqrt(np.asarray(columns.multiply(columns).sum(axis=0)).ravel())
    return csr_array(columns @ diags_array(1 / np.where(length > 0, length, 1.0)))


def _rank(matrix: Floats) -> int:
    if 0 in matrix.shape:
        return 0
    s = svdvals(matrix)
    return int((s > _RANK * s[0]).sum())


def _counted(equation: ForceEquation, noise: NoiseModel, acting: csr_array, data: str) -> int:
    """d of a disordered network: the conditions left over, or the sources, if they are fewer."""
    network, forest = equation.network, equation.network.forest
    if network.walls is not None or network.free.any():
        return _counted_between_walls(equation, acting, data)
    labels, part = np.unique(forest.component[network.active], return_inverse=True)
    count, winding = len(labels), forest.winding_rank[labels]
    of_contact = np.searchsorted(labels, forest.component[network.pairs[:, 0]])
    c = np.bincount(of_contact, minlength=count)
    balances = (3 if equation.frictional else 2) * np.bincount(part, minlength=count) - 2
    moments = np.zeros(count, dtype=np.int64)
    if equation.frictional:
        columns = csc_array(moments_left_free(equation, noise.loads))
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
    balances, Q = equation.M.shape[0], equation.Q
    of_grain = part[row % len(equation.network.active)]
    if acting.shape[0] == balances:
        return of_grain
    loop = np.maximum(row - balances, 0)
    return np.where(row < balances, of_grain, of_contact[Q.indices[Q.indptr[loop]]])


def _of_loads(equation: ForceEquation, noise: NoiseModel) -> int:
    """Net forces of components that nothing holds, which are conditions on noisy loads alone."""
    if noise.loads is None:
        return 0
    network = equation.network
    component = network.forest.component[network.active]
    held = np.isin(component, held_components(network))
    labels, part = np.unique(component[~held], return_inverse=True)
    if not len(labels):
        return 0
    mine, n = np.flatnonzero(~held), len(network.active)
    sums = csr_array((np.ones(len(mine)), (part, mine)), shape=(len(labels), n))
    net = [sums @ noise.loads[axis * n : (axis + 1) * n] for axis in (0, 1)]
    return int(sum(np.count_nonzero(abs(rows).sum(axis=1)) for rows in net))


def _counted_between_walls(equation: ForceEquation, acting: csr_array, data: str) -> int:
    """d as of one component: walls hold all of them."""
    network, c, closing = equation.network, equation.network.contacts, equation.matrices.closing
    left = equation.M.shape[0] - trivial_balances(network, equation.frictional)
    columns = csc_array(acting)
    columns.eliminate_zeros()
    sources = int((np.diff(columns.indptr) > 0).sum())
    if data == "sizes":
        closures = 2 * len(closing.loops) + closing.lines.independent
        left += min(closures, c - 1) - equation.unknowns
        loaded = network.external.any() or len(equation.matrices.balancing.walls)
        sources -= 0 if loaded else 1
    elif equation.frictional:
        left -= c
    return min(left, sources)
