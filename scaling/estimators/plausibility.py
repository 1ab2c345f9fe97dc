"""Data at odds with themselves: impossible overlaps, and forces beyond the friction told.

Contacts of real grains are compressed by a small part of their diameter. Beyond ⟨δ⟩ = 0.2 ⟨σ⟩
no contact law holds: such overlaps come from diameters taken for radii (⟨δ⟩ = 0.5 ⟨σ⟩, all
forces exactly doubled) or from lengths in two units. Where only directions are known, loops
that wind around a periodic cell tell the same: Σ ± σ n is too long for the lattice vector Λ
that it spans.
"""

from __future__ import annotations

import warnings

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.callers import outside
from scaling.equation.force_equation import ForceEquation
from scaling.geometry.contact_network import ContactNetwork

DEEPEST = 0.2
"""Mean overlap over the mean diameter of the grains in contact."""
FARTHEST = 0.5
"""Mean gap, likewise; noise makes gaps, but on average it makes as many overlaps."""
_EXCESS = 1e-6
"""|f_t| - μ f_n, in ⟨f_n⟩, that rounding may make."""


class BeyondFrictionWarning(UserWarning):
    """Forces found exceed the friction that was told."""


def refuse_deep_overlaps(network: ContactNetwork) -> None:
    """ValueError where grains overlap by more than 0.2 ⟨σ⟩ on average, or are 0.5 ⟨σ⟩ apart."""
    depth = mean_overlap(network)
    if -FARTHEST <= depth <= DEEPEST:
        return
    limit = DEEPEST if depth > 0 else FARTHEST
    if depth > 0:
        cause = "diameters given as radii, or radii and positions in different units"
        what = "overlap by"
    else:
        cause = "radii in another unit than positions, or half radii"
        what = "are apart by"
    raise ValueError(
        f"grains in contact {what} {abs(depth):.3g} of their diameters on average, beyond "
        f"{limit:g}: no contact force follows from that. Likely cause: {cause}"
    )


def mean_overlap(network: ContactNetwork) -> float:
    """⟨σ - r⟩/⟨σ⟩ over contacts; of loops that wind, if there are directions only; else 0."""
    if not network.contacts:
        return 0.0
    if network.positions is not None:
        return float(network.overlaps.mean() / network.sigma.mean())
    loops = network.topology.tree_windings
    if not len(loops) or network.cell is None:
        return 0.0
    way = loops.incidence @ (network.sigma[:, None] * network.normals)
    Λ = loops.images @ network.cell
    length = np.linalg.norm(Λ, axis=1)
    return float(np.mean(1 - length / (np.sum(way * Λ, axis=1) / length)))


def beyond_friction(equation: ForceEquation, forces: Floats, friction: float) -> int:
    """The number of contacts with |f_t| > μ f_n; BeyondFrictionWarning if there are any."""
    c = equation.network.contacts
    fn, ft = forces[:c], forces[c:]
    mean = float(np.mean(abs(fn)))
    excess = abs(ft) - friction * np.maximum(fn, 0.0)
    beyond = excess > _EXCESS * mean
    if beyond.any():
        e = int(np.argmax(excess))
        i, j = equation.network.pairs[e]
        warnings.warn(
            f"{beyond.sum()} of {c} contacts bear more than friction {friction:g} allows, most "
            f"contact {e} (grains {i} and {j}): f_t = {ft[e]:.3g}, f_n = {fn[e]:.3g}. Likely "
            "cause: noise in the data, a friction coefficient that is too small, or normal "
            "forces without their viscous parts",
            BeyondFrictionWarning,
            stacklevel=outside(),
        )
    return int(beyond.sum())
