"""The moment of each part of an open component, as a combination of the rows of M.

Internal forces balance in it up to O(Δ) only (lever arms R_i at contacts that overlap): enforced
on noisy directions it would amplify their noise by 1/Δ, so estimators leave it free. A bridge, a
contact on no loop, cannot transmit moment either, so the parts that bridges join (a dangling
grain, say) are counted one by one.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from scaling.equation.force_equation import ForceEquation
from scaling.equation.strain import strain_of
from scaling.geometry.bodies import held_components, weighed
from scaling.geometry.contact_network import ContactNetwork

_WELL_ABOVE = 30.0
"""Times the O(Δ) that lever arms are off by: what a moment errs by where it is a condition."""


def global_moments(network: ContactNetwork) -> csr_array:
    """(rows of M, parts): rows of M combined to the moment of each part, columns of unit length.

    None for what winds a periodic cell or touches a wall, and none if only directions are known.
    """
    active, forest = network.active, network.forest
    walls = len(weighed(network))
    none = csr_array((3 * len(active) + walls, 0))
    if network.positions is None:
        return none
    looped = ~network.topology.bridges
    winds = forest.winding_rank[forest.component] > 0
    winds |= np.isin(forest.component, held_components(network))
    between = network.pairs[: network.inner]
    i, j = between[looped | winds[between[:, 0]]].T
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
        turned = np.where(mine, network.radii[active], 0.0)
        v = np.concatenate([-y[:, 1], y[:, 0], turned, np.zeros(walls)])
        columns.append(v / np.linalg.norm(v))
    return csr_array(np.column_stack(columns)) if columns else none


def moments_left_free(equation: ForceEquation, load_errors: csr_array | None) -> csr_array:
    """`global_moments` of an equation with friction, none without; but for those of components
    whose loads err by far more than the O(Δ) by which lever arms are off: they are then conditions
    as all others, that the loads can meet.

    `load_errors`: E (rows of M, l) of `scaling.estimators.told.loads`, None for exact loads.
    """
    if not equation.frictional:
        return csr_array((equation.M.shape[0], 0))
    columns = global_moments(equation.network)
    if load_errors is None or not load_errors.shape[1] or not columns.shape[1]:
        return columns
    error = columns.T @ load_errors
    error = np.sqrt(np.asarray(error.multiply(error).sum(axis=1)).ravel())
    off = strain_of(equation.network) * (abs(columns).T @ abs(equation.balance_rhs()))
    by_column, active = csc_array(columns), equation.network.active
    first = by_column.indices[by_column.indptr[:-1]] % len(active)
    # Parts that bridges join bear the loads of each other.
    component = equation.network.forest.component[active[first]]
    return csr_array(columns[:, ~np.isin(component, component[error > _WELL_ABOVE * off])])
