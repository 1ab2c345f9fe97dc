"""Loads that no contact forces can balance are refused before any force is given out.

M|f⟩ = -|F_ext⟩ has solutions only if the loads do no work in any motion that leaves all contacts
at rest, wᵀM = 0. These motions are

    translation   of each component: Σ F = 0, also if it winds a periodic cell, once or twice
    rotation      of each open component: Σ (x × F + T) = -Σ f_t δ, 0 up to O(δ), as the lever
                  arms are R_i. On a torus, and for a ribbon, there is none
    mechanisms    a grain that dangles on one contact, a chain that bends, and the like

The first is checked here to the digits of the data, the second to Σ|f_t| δ, estimated by
Σ (|x||F| + |T|) δ/σ, with what noisy positions add to it; the third by `scaling.mechanisms`.

Digits of the data: half of those of doubles, which is more than simulations at rest keep; fewer
where the loads, the forces that they come from, or the coordinates are rounded.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse.linalg import lsmr

from packing.arrays import Floats, Integers
from scaling.equation import ForceEquation
from scaling.resolution import (
    EVIDENCE,
    force_rounding,
    resolution,
    rounding_steps,
    significant_digits,
)
from scaling.strain import strain_of

if TYPE_CHECKING:
    from scaling.network import ContactNetwork

DIGITS = float(np.sqrt(np.finfo(float).eps))
"""Relative imbalance that plain doubles may have, of Σ|F|."""
_TYPED = 3
"""Up to so many digits a few numbers are what was typed, and nothing was rounded."""
_SIGMAS = 6.0
"""Multiple of a standard deviation that rounding does not exceed."""
_MOMENT = 3.0
"""Times Σ(|x||F| + |T|) δ/σ, rms: the largest δ is about three times the rms."""
_TURNED = 4.0
"""Angles by which directions may be off, in rms δ/σ."""
_RESTARTS = 3
"""Of LSMR, on what it left: a load in the range of M shrinks by ~1e7 each time."""
_LARGEST_STRAIN = 0.1
"""Lists of contacts with wider gaps are no measured packings: their directions are meant."""
_NAMED = 5


def refuse_unbalanced(equation: ForceEquation) -> None:
    """ValueError, with numbers and the likely cause, where Σ F or Σ (x × F + T) is not 0.

    A scene without loads costs nothing.
    """
    network = equation.network
    if network.external.any():
        steps, relative = _rounding_of_loads(network)
        _refuse_net_force(network, steps, relative)
        _refuse_net_torque(network, steps, relative, strain_of(network))


def refuse_mechanisms(equation: ForceEquation, forces: Floats | None = None) -> None:
    """ValueError, naming the grains, for loads in part outside the range of M.

    `forces` that balance them are proof enough of the contrary.
    Loads once accepted are not looked at again for networks that share directions (other sizes).
    """
    b = equation.balance_rhs()
    if not b.any():
        return
    strain = strain_of(equation.network)
    kept, key = equation.network._geometry, ("balanced loads", equation.frictional)
    if key in kept and kept[key][1] <= strain and np.array_equal(kept[key][0], b):
        return
    f = np.zeros(equation.unknowns) if forces is None else forces
    found = _unbalanced_part(equation, b, f, strain)
    if found is not None:
        raise ValueError(_mechanism(equation, *found))
    kept[key] = b, strain


def strain_of(network: ContactNetwork) -> float:
    """By how much directions and lever arms may be off, rms: δ/σ, or what closure leaves of σ.

    Deformations and noise of lengths widen the overlaps alike. Of directions that were measured,
    the angle to those of the positions counts too, or the loops, if there are no positions.
    """
    strains = [0.0]
    if network.positions is not None:
        strains.append(_rms(network.overlaps / network.sigma))
        if network._directions_measured:
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
    i, j = network.pairs.T
    branch = network.positions[j] - network.positions[i]
    if network.cell is not None:
        branch = branch + network.images @ network.cell
    return np.sum(branch * network.tangents, axis=1) / network.distances


def _closure_error(network: ContactNetwork) -> float:
    """Rms of Σ ± σ n - Λ over the loops, a length."""
    loops = network.loops
    sums = loops.incidence @ (network.sigma[:, None] * network.normals)
    if network.cell is not None:
        sums = sums - loops.images @ network.cell
    return _rms(sums)


# --- digits -------------------------------------------------------------------------------


def _rounding_of_loads(network: ContactNetwork) -> tuple[Floats, float]:
    """((N, 3) steps h of rounded loads, 0 if they are doubles; relative rounding of all)."""
    external = network.external
    steps = np.zeros_like(external)
    for columns in (slice(0, 2), slice(2, 3)):
        values = external[:, columns]
        kind = _kind(values[values != 0])
        if kind:
            steps[:, columns] = np.where(values == 0, 0.0, rounding_steps(values, kind))
    return steps, max(network._load_rounding, force_rounding(network))


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
    return float(min(np.sum(h) / 2, _SIGMAS * np.sqrt(np.sum(h**2) / 12)))


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
        moved = _SIGMAS * network.mean_diameter * float(np.linalg.norm(F))
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


def _unbalanced_part(
    equation: ForceEquation, b: Floats, forces: Floats, strain: float
) -> tuple[Floats, float] | None:
    """(b - M f at its least, what a grain may have of it), None if no grain has more."""
    network = equation.network
    steps, relative = _rounding_of_loads(network)
    rows_of = np.column_stack([np.ones((network.grains, 2)), 1 / network.radii])
    largest = float(abs(b).max())
    allowed = (DIGITS + relative) * largest + _SIGMAS / 2 * float((steps * rows_of).max())
    least = allowed + _TURNED * strain * largest
    # Only forces no larger than loads excuse an imbalance: those from bad data may have any size.
    if per_grain(equation, b - equation.M @ forces).max() <= least:
        return None
    f, left, bound = np.zeros(equation.unknowns), b, least
    for _ in range(_RESTARTS):
        d, left = projected(equation, left, 0.1 * least)
        f = f + d
        bound = allowed + _TURNED * strain * max(float(abs(f).max()), largest)
        if per_grain(equation, left).max() <= bound:
            return None
    return left, bound


def projected(equation: ForceEquation, b: Floats, small: float) -> tuple[Floats, Floats]:
    """(f, b - M f), what is left of the load b at the least |b - M f|; done when it is `small`."""
    size = float(np.linalg.norm(b))
    most = 20 * int(np.sqrt(equation.unknowns)) + 1000
    f = lsmr(
        equation.M, b / size, atol=1e-9, btol=min(small / size, 1.0), conlim=0, maxiter=most
    )[0]  # fmt: skip
    f = f * size
    return f, b - equation.M @ f


def per_grain(equation: ForceEquation, rows: Floats) -> Floats:
    """The magnitude, on each grain with contacts, of what rows of balance say."""
    return np.sqrt(np.sum(rows.reshape(3 if equation.frictional else 2, -1) ** 2, axis=0))


def _mechanism(equation: ForceEquation, left: Floats, allowed: float) -> str:
    off = per_grain(equation, left)
    grains = equation.matrices.active[np.argsort(-off)[: int((off > allowed).sum())]]
    network = equation.network
    worst = int(grains[0])
    k = int(np.flatnonzero(equation.matrices.active == worst)[0])
    part = ", ".join(f"{-x:.3g}" for x in left.reshape(-1, len(off))[:, k])
    kind = "(F_x, F_y, T/R)" if equation.frictional else "(F_x, F_y)"
    names = ", ".join(map(str, grains[:_NAMED].tolist()))
    more = ", ..." if len(grains) > _NAMED else ""
    touches = int(network.degrees[worst])
    return (
        f"the loads cannot be balanced: {len(grains)} grains ({names}{more}) bear a part that no "
        f"contact forces balance. The largest, {off[k]:.3g}, is {kind} = ({part}) on grain "
        f"{worst}, which has {touches} contact{'s' if touches > 1 else ''}; the data allow "
        f"{allowed:.1e}. Likely cause: a mechanism, such as a grain loaded across its only "
        "contact or a chain that bends, or a contact that is missing in the list"
    )


def _components(network: ContactNetwork) -> list[tuple[Integers, int]]:
    """(grains, directions of winding) of each component that bears a load."""
    forest = network.forest
    order = np.argsort(forest.component, kind="stable")
    sizes = np.bincount(forest.component)
    parts = np.split(order, np.cumsum(sizes)[:-1])
    loaded = np.unique(forest.component[network.external.any(axis=1)])
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
