"""Loads that no contact forces can balance are refused before any force is given out.

M|f⟩ = -|F_ext⟩ has solutions only if the loads do no work in any motion that leaves all contacts
at rest, wᵀM = 0. These motions are

    translation   of each component: Σ F = 0, also if it winds a periodic cell, once or twice
    rotation      of each open component: Σ (x × F + T) = -Σ f_t δ, 0 up to O(δ), as the lever
                  arms are R_i. On a torus, and for a ribbon, there is none
    mechanisms    a grain that dangles on one contact, a chain that bends, and the like

The first is checked here to the digits of the data, the second to Σ|f_t| δ, estimated by
Σ (|x||F| + |T|) δ/σ, with what noisy positions add to it; the third by
`scaling.equation.mechanisms`.

Digits of the data: half of those of doubles, which is more than simulations at rest keep; fewer
where the loads, the forces that they come from, or the coordinates are rounded.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.coordinate_rounding import (
    EVIDENCE,
    resolution,
    rounding_steps,
    significant_digits,
)
from scaling.equation.force_equation import ForceEquation
from scaling.equation.strain import strain_of
from scaling.geometry.bodies import held_components
from scaling.geometry.coarse_coordinates import force_rounding
from scaling.geometry.contact_network import ContactNetwork

DIGITS = float(np.sqrt(np.finfo(float).eps))
"""Relative imbalance that plain doubles may have, of Σ|F|."""
_TYPED = 3
"""Up to so many digits a few numbers are what was typed, and nothing was rounded."""
SIGMAS = 6.0
"""Multiple of a standard deviation that rounding does not exceed."""
_MOMENT = 3.0
"""Times Σ(|x||F| + |T|) δ/σ, rms: the largest δ is about three times the rms."""


def refuse_unbalanced(equation: ForceEquation) -> None:
    """ValueError, with numbers and the likely cause, where Σ F or Σ (x × F + T) is not 0.

    A scene without loads costs nothing. Loads with error bars: `scaling.estimators.told.loads`.
    """
    network = equation.network
    if network.external.any():
        steps, relative = rounding_of_loads(network)
        _refuse_net_force(network, steps, relative)
        _refuse_net_torque(network, steps, relative, strain_of(network))


# --- digits -------------------------------------------------------------------------------


def rounding_of_loads(network: ContactNetwork) -> tuple[Floats, float]:
    """((N, 3) steps h of rounded loads, 0 if they are doubles; relative rounding of all)."""
    external = network.external
    steps = np.zeros_like(external)
    for columns in (slice(0, 2), slice(2, 3)):
        values = external[:, columns]
        kind = _kind(values[values != 0])
        if kind:
            steps[:, columns] = np.where(values == 0, 0.0, rounding_steps(values, kind))
    return steps, max(network.load_rounding, force_rounding(network))


def _kind(values: Floats) -> str:
    """How loads were rounded: as many numbers show it, or a few that have more than 3 digits."""
    seen = resolution(values).kind if values.size else "float64"
    if seen != "float64":
        return seen
    digits = significant_digits(values)
    few = len(np.unique(values)) < EVIDENCE
    return f"{digits} digits" if few and digits is not None and digits > _TYPED else ""


def _slack(steps: Floats, weights: Floats | float = 1.0) -> float:
    """What rounding to `steps` may add to a weighted sum: at worst, or with probability one."""
    h = weights * steps
    return float(min(np.sum(h) / 2, SIGMAS * np.sqrt(np.sum(h**2) / 12)))


# --- the three kinds of motion ------------------------------------------------------------


def _refuse_net_force(network: ContactNetwork, steps: Floats, relative: float) -> None:
    F = network.external[:, :2]
    size = np.hypot(*F.T)
    for grains, winding in _components(network):
        net, total = F[grains].sum(axis=0), float(size[grains].sum())
        slack = max(DIGITS, relative) * total + _slack(steps[grains, :2])
        if np.hypot(*net) <= slack:
            continue
        where = {0: "open", 1: "wound in one direction", 2: "wound in both directions"}[winding]
        raise ValueError(
            f"the loads cannot be balanced: those on the {len(grains)} grains of the component of "
            f"grain {grains[0]} ({where}) add up to ({net[0]:.4g}, {net[1]:.4g}), "
            f"{np.hypot(*net) / total:.1e} of Σ|F| = {total:.4g}, where the digits of the data "
            f"allow {slack / total:.1e}. Likely cause: forces of walls, or of contacts cut at "
            "the boundary, are missing in external"
        )


def _refuse_net_torque(
    network: ContactNetwork, steps: Floats, relative: float, strain: float
) -> None:
    places = _places(network)
    for grains, winding in _components(network):
        if winding:
            continue
        x = places[grains] - places[grains].mean(axis=0)
        F, T = network.external[grains, :2], network.external[grains, 2]
        net = float(np.sum(x[:, 0] * F[:, 1] - x[:, 1] * F[:, 0] + T))
        arm, size = np.hypot(*x.T), np.hypot(*F.T)
        scale = float(np.sum(arm * size + abs(T)))
        moved = SIGMAS * network.mean_diameter * float(np.linalg.norm(F))
        slack = max(DIGITS, relative) * scale + strain * (_MOMENT * scale + moved)
        slack += _slack(steps[grains, :2].max(axis=1), 2 * arm) + _slack(steps[grains, 2])
        if abs(net) > slack:
            raise ValueError(
                f"the loads cannot be balanced: those on the {len(grains)} grains of the "
                f"component of grain {grains[0]} have the net torque {net:.4g}, "
                f"{abs(net) / scale:.1e} of Σ(|x||F| + |T|) = {scale:.4g}, where lever arms "
                f"R_i at overlaps of δ/σ = {strain:.1e} allow {slack / scale:.1e}. Likely "
                "cause: torques of walls or of cut contacts, R_i f_t, are missing in external, "
                "or the torques are about another point than the centres of the grains"
            )


def _components(network: ContactNetwork) -> list[tuple[Integers, int]]:
    """(grains, directions of winding) of each component that bears a load and no wall holds."""
    forest = network.forest
    order = np.argsort(forest.component, kind="stable")
    sizes = np.bincount(forest.component)
    parts = np.split(order, np.cumsum(sizes)[:-1])
    loaded = np.unique(forest.component[network.external.any(axis=1)])
    loaded = np.setdiff1d(loaded, held_components(network))
    return [(parts[k], int(forest.winding_rank[k])) for k in loaded]


def _places(network: ContactNetwork) -> Floats:
    """Unwrapped positions, or those of touching grains along the spanning trees."""
    forest = network.forest
    if network.positions is not None:
        x = network.positions
        return x if network.cell is None else x + forest.shift @ network.cell
    child = np.flatnonzero(forest.edge >= 0)
    e = forest.edge[child]
    x = np.zeros((network.grains, 2))
    x[child] = (forest.sign[child] * network.sigma[e])[:, None] * network.normals[e]
    ancestor = forest.parent
    while (ancestor != ancestor[ancestor]).any():
        x = x + x[ancestor]
        ancestor = ancestor[ancestor]
    return x
