"""Is this record a packing at rest?  What is refused, with culprit and number."""

from __future__ import annotations

import numpy as np

from packing.arguments.numbers import SMALLEST
from packing.boundary.walls import FREE, Walls
from packing.contacts import contact_list
from packing.doubledouble import EPS
from packing.packing_data import PackingData

#: Largest force or torque residual, in p⟨σ⟩, that still counts as balanced.  Integration to
#: ⟨v⟩ < 1e-8 leaves ~ 1e-8 Δ^(-1/2); a packing in motion has residuals of order 1.
BALANCED = 1e-2
#: A force-bearing contact is no wider open than this many round-off units ε L.
TOUCHING = 1000


def check_packing(p: PackingData) -> None:
    """ValueError for what is no packing at rest; numbers that overflow on the way are none."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        check_grains(p)
        check_low_parts(p)
        check_contacts(p)
        check_forces(p)


def check_grains(p: PackingData) -> None:
    """Grains have a radius, their cell an area."""
    if bad := np.flatnonzero(p.radii <= 0).tolist():
        raise ValueError(f"grain {bad[0]} has radius {p.radii[bad[0]]}, not positive")
    if bad := np.flatnonzero(p.radii < SMALLEST).tolist():
        raise ValueError(f"grain {bad[0]} has radius {p.radii[bad[0]]}, below {SMALLEST:g}")
    if p.cell is None:
        return
    side = float(np.abs(p.cell).max())
    if side < SMALLEST or abs(np.linalg.det(p.cell / side)) < 1e-12 * np.sum((p.cell / side) ** 2):
        raise ValueError(f"cell {p.cell.tolist()} is singular")


def check_low_parts(p: PackingData) -> None:
    """What the doubles leave out is no more than an ulp of them."""
    for name in ("positions", "radii", "cell"):
        low = getattr(p, f"{name}_low")
        if low is None:
            continue
        high = getattr(p, name)
        if large := np.argwhere(np.abs(low) > np.spacing(np.abs(high))).tolist():
            k = tuple(large[0])
            raise ValueError(
                f"{name}_low{large[0]} is {low[k]:.3g}, more than an ulp of its {high[k]:.17g}"
            )


def check_contacts(p: PackingData) -> None:
    """Contacts join known grains, i < j (or i = j through an image), each once."""
    walls = 0 if p.walls is None else len(p.walls)
    contact_list.contacts(p.pairs, p.images, len(p.radii), walls)
    p.boundary.refuse_images(p.images)
    if p.walls is not None:
        check_walls(p)


def check_walls(p: PackingData) -> None:
    """Low parts are not known between walls; what is glued to a wall does not touch it."""
    assert p.walls is not None
    for name in ("positions", "radii", "cell"):
        if getattr(p, f"{name}_low") is not None:
            raise ValueError(f"{name}_low is given, but between walls low parts are not known")
    glued = p.walls.glued_grains(len(p.radii)) != FREE
    stuck = glued[p.pairs[:, 0]] & np.append(glued, np.ones(len(p.walls), bool))[p.pairs[:, 1]]
    if stuck.any():
        e = int(np.argmax(stuck))
        raise ValueError(
            f"contact {e} {tuple(p.pairs[e].tolist())} joins what is glued to walls: it bears no "
            "force that balance could tell"
        )


def check_forces(p: PackingData) -> None:
    """Contacts touch, push, hold their friction and balance; the virial is the pressure."""
    size = 2 * float(p.radii.mean())
    span = float(np.ptp(p.positions, axis=0).max()) if p.cell is None else p.width
    ulp = np.finfo(float).eps if p.positions_low is None else EPS
    allowed = TOUCHING * ulp * (span + size)
    if (together := p.branches == 0).any():
        e = int(np.argmax(together))
        raise ValueError(
            f"contact {e} {tuple(p.pairs[e].tolist())} joins two centres at one point: no normal"
        )
    gap = -p.overlaps
    if len(gap) and not gap.max() <= allowed:
        e = int(gap.argmax())
        raise ValueError(
            f"contact {e} {tuple(p.pairs[e].tolist())} does not touch: it is open by {gap[e]:.3g}"
        )
    slack = BALANCED * p.pressure * size
    for name, excess in (
        ("pulls", -p.normal_forces - slack),
        (
            f"exceeds the Coulomb cap of friction {p.friction:g}",
            np.abs(p.tangential_forces) - p.friction * p.normal_forces - slack,
        ),
    ):
        if (excess > 0).any():
            e = int(excess.argmax())
            raise ValueError(
                f"contact {e} {name}: f_n = {p.normal_forces[e]:.3g}, "
                f"f_t = {p.tangential_forces[e]:.3g}, pressure {p.pressure:.3g}"
            )
    residual = p.residuals()
    if not residual.max(initial=0.0) <= BALANCED:
        grain = int(residual.argmax())
        raise ValueError(
            f"the forces on grain {grain} do not balance: "
            f"residual {residual[grain]:.3g} p⟨σ⟩, allowed {BALANCED}"
        )
    _check_pressure(p)


def _check_pressure(p: PackingData) -> None:
    """In a cell the virial Σ f_n r/2A is the pressure: balance alone leaves the scale free."""
    if p.walls is not None:
        return _check_loads(p, p.walls)
    if p.cell is None:
        return None
    area = abs(float(np.linalg.det(p.cell)))
    virial = float(p.normal_forces @ np.abs(p.branches)) / (2 * area)
    if not abs(virial / p.pressure - 1) <= BALANCED:
        raise ValueError(
            f"the forces carry a pressure of {virial:.4g}, not the {p.pressure:.4g} stated"
        )
    return None


def _check_loads(p: PackingData, walls: Walls) -> None:
    """Walls whose load is known bear it."""
    n = walls.normals[:, 0] + 1j * walls.normals[:, 1]
    borne = (p.wall_forces() * n.conj()).real
    for k in walls.known.tolist():
        if not abs(borne[k] - walls.loads[k]) <= BALANCED * abs(walls.loads[k]):
            raise ValueError(
                f"the grains press on wall {k} with {borne[k]:.4g}, not the {walls.loads[k]:.4g} "
                "of its load"
            )
