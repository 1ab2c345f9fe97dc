"""The order in which the conditions of `bounded` are eliminated: where grains lie.

    K = [ P   Eᵀ ]        z = (f ; g η ; …) , and a multiplier for each row of E
        [ E  -s  ]

Each force, source of noise and row belongs to a grain: a source to the one it moves or swells, a
balance to its own, a force and the datum of a contact to that of its two grains that comes first.
Grains come in the order of nested dissection (`packing.contacts.dissection`). Of one grain, forces
come before multipliers, so that every pivot has its size from P: s, which only keeps redundant
conditions apart, divides nothing that is not redundant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Integers
from packing.contacts.dissection import Dissection, dissection
from scaling.estimators.bounded.posterior import Posterior
from scaling.geometry.places import grain_places
from scaling.noise.noise_model import NoiseModel

LEAF = 24
"""Grains that are eliminated together."""
_FORCE, _BOUND, _SOURCE, _DATUM, _BALANCE = range(5)


@dataclass(frozen=True, eq=False)
class Sites:
    """Where in the order grains come, `rank` (N + 1,), the last for what meets all of them; so
    sources of noise (k,) and balances; and where leaves and separators begin."""

    rank: Integers
    sources: Integers
    balances: Integers
    starts: Integers


def sites_of(p: Posterior) -> Sites | None:
    """None where there is no such order: distances are no data, a source acts on several grains,
    gaps are unknowns, or no positions are known."""
    network, noise = p.equation.network, p.noise
    places = grain_places(network)
    if noise is None or p.data != "all" or p.gaps or places is None:
        return None
    acting = _grain_of_source(noise, network.grains)
    if acting is None:
        return None
    parts = network.shared.get(
        Dissection, LEAF, lambda: dissection(places, network.pairs[: network.inner], LEAF)
    )
    rank = np.empty(network.grains + 1, np.int64)
    rank[parts.order] = np.arange(network.grains)
    rank[-1] = network.grains
    grain_of_row = p.equation.matrices.balancing.grain_of_row
    return Sites(rank, rank[acting], rank[grain_of_row], parts.starts)


def elimination_order(p: Posterior, columns: int, rows: int, met: Integers) -> Integers | None:
    """Of the unknowns and multipliers of K: `columns` unknowns, `rows` equalities, then bounds.

    `met` (b,) are the contacts of these. None where there is no such order, see `sites_of`.
    """
    sites = sites_of(p)
    if sites is None:
        return None
    network, noise, rank = p.equation.network, p.noise, sites.rank
    assert noise is not None
    contact = rank[np.minimum(network.pairs, network.grains)].min(axis=1)
    balances = p.equation.M.shape[0]
    forces = np.tile(contact, p.equation.unknowns // network.contacts)
    blocks = [(forces, _FORCE), (sites.sources, _SOURCE)]
    # Moments of the loads meet all grains, what the second order adds has a contact of its own.
    rest = columns - len(forces) - noise.count
    second = np.concatenate([np.full(rest % network.contacts, rank[-1]),
                             np.tile(contact, rest // network.contacts)])  # fmt: skip
    blocks += [
        (second, _FORCE),
        (sites.balances, _BALANCE),
        (contact, _DATUM),
        (np.full(rows - balances - network.contacts, rank[-1]), _BALANCE),
        (contact[met], _BOUND),
    ]
    place = np.concatenate([where for where, _ in blocks])
    turn = np.concatenate([np.full(len(where), kind) for where, kind in blocks])
    return np.lexsort((turn, place))


def _grain_of_source(noise: NoiseModel, grains: int) -> Integers | None:
    """(k,) the grain on which each source acts, any for none; None if one acts on several."""
    weights = abs(noise.radii) + abs(noise.positions[:grains]) + abs(noise.positions[grains:])
    weights = weights.tocsc()
    weights.eliminate_zeros()
    number = np.diff(weights.indptr)
    if (number > 1).any():
        return None
    acting = np.zeros(noise.count, np.int64)
    acting[number == 1] = weights.indices
    return acting
