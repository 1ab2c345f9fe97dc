"""By how much directions and lever arms of a network may be off, told from its lengths.

Deformations and noise of lengths widen the overlaps alike: with noise ξ of positions a direction
turns by √2 ξ/r, and σ - r scatters by √2 ξ. So δ/σ, rms, bounds both the O(Δ) that lever arms R_i
leave of moments, and the angle by which directions are wrong.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.coordinate_rounding import resolution
from scaling.geometry.contact_network import ContactNetwork

_LARGEST_STRAIN = 0.1
"""Lists of contacts with wider gaps are no measured packings: their directions are meant."""


def strain_of(network: ContactNetwork) -> float:
    """By how much directions and lever arms may be off, rms: δ/σ, or what closure leaves of σ.

    Deformations and noise of lengths widen the overlaps alike. Of directions that were measured,
    the angle to those of the positions counts too, or the loops, if there are no positions.
    """
    strains = [0.0]
    if network.positions is not None:
        strains.append(_rms(network.overlaps / network.sigma))
        if network.directions_measured:
            strains.append(_rms(_misaligned(network)))
    else:
        strains.append(resolution(network.normals).noise)
        try:
            loops = network.loops
        except ValueError:  # faces that are no discs: no evidence from loops
            return min(max(strains), _LARGEST_STRAIN)
        if len(loops):
            strains.append(_closure_error(network) / network.mean_diameter)
    return min(max(strains), _LARGEST_STRAIN)


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _misaligned(network: ContactNetwork) -> Floats:
    """sin of the angle between directions measured and those of the positions."""
    assert network.positions is not None
    branch = network.boundary.branches(network.positions, network.pairs, network.images)
    return np.sum(branch * network.tangents, axis=1) / network.distances


def _closure_error(network: ContactNetwork) -> float:
    """Rms of Σ ± σ n - Λ over the loops, a length."""
    loops = network.loops
    sums = loops.incidence @ (network.sigma[:, None] * network.normals)
    if network.cell is not None:
        sums = sums - loops.images @ network.cell
    return _rms(sums)
