"""The reference kernel: one time step in NumPy, the plane as complex numbers.

With d = z_j - z_i, n = d/r and t = i n, a contact pulls grain i by (-f_n + i f_t) n and j by
the opposite, and turns both by R f_t.  Surface speeds s = R ω stand for the spins, so that
ds/dt = 2 (Σ f_t)/m beside dv/dt = (Σ f)/m.

Where slip adds to f_t at the k_t of its time, elongations change with k_t: the overlap of a step
ago is that of the branch before the drift.

Velocity Verlet: half a kick, then drift, forces, kick, ..., and half a kick at the end.  The
slip of a contact over a step is taken in the frame at mid-step, where d is d - (v_j - v_i) dt/2:
that keeps the scheme of second order with history.
"""

from __future__ import annotations

import numpy as np

from dem.model.drive import Drive
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.kernels.motion import Forces, Motion
from packing.arguments.arrays import Floats

#: Pairs treated at a time.  What lies between positions and forces stays in the cache, and each
#: array below the 128 kB from which the allocator asks the system anew: at 1e5 grains 2.5 times
#: faster.
BLOCK = 4096


def refuse_law(law: ContactLaw) -> None:
    """Every law is known here."""


def contact_forces(m: Motion, near: Neighbours, law: ContactLaw, dt: float) -> Forces:
    """Forces at the present positions; tangential history advanced by the last ``dt``."""
    count = len(near.sigma)
    force = np.empty(count, m.z.dtype)
    tangential = np.empty(count if law.friction else 0, m.s.dtype)
    virial = 0.0
    for first in range(0, count, BLOCK):
        pairs = slice(first, first + BLOCK)
        mine = law if law.linear else law.of(near.effective_radii[pairs])
        virial += _pair_forces(m, near, mine, dt, pairs, force[pairs], tangential[pairs])
    twist = near.adjacency @ tangential if law.friction else np.zeros_like(m.s)
    found = Forces(near.incidence @ force, twist, virial)
    if m.outside is not None:
        found.onto = m.outside.act(m.z, m.v, m.s, dt, found.pull, found.twist)
    return found


def _pair_forces(
    m: Motion,
    near: Neighbours,
    law: ContactLaw,
    dt: float,
    pairs: slice,
    force: np.ndarray,
    tangential: Floats,
) -> float:
    """Fill ``force`` (on grain i) and ``tangential`` of some pairs; their Σ f_n r."""
    i, j = near.columns[:, pairs]
    d = m.z[j] - m.z[i] + near.shift[pairs] * m.scale
    r = np.abs(d)
    n = d / r
    overlap = np.maximum(near.sigma[pairs] - r, 0.0)
    normal = law.force(overlap)
    if law.friction or law.dashpot:
        slip = (m.v[j] - m.v[i]) * n.conj()
    if law.dashpot:
        approach = slip.real + m.rate * r
        normal = np.where(normal > 0, np.maximum(normal - law.dashpot * approach, 0.0), 0.0)
    if not law.friction:
        np.multiply(-normal, n, out=force)
        return float(normal @ r)
    turn = m.s[i] + m.s[j]
    u = near.elongation[pairs]
    if law.incremental:
        before = (d - dt * (m.v[j] - m.v[i])) / (1 + m.rate * dt)
        u *= law.kept(near.sigma[pairs] - np.abs(before), overlap)
    u += dt * (slip.imag / (1 - 0.5 * dt * slip.real / r) - turn)
    # A force of zero keeps no memory: an open contact has cap 0, hence u = 0.
    cap = law.friction * normal
    k_t = law.tangential_stiffness(overlap)
    np.minimum(np.maximum(k_t * u, -cap), cap, out=tangential)
    if isinstance(k_t, float):
        np.divide(tangential, k_t, out=u)
    else:
        u[:] = law.elongation(tangential, overlap)
    force.real = -normal
    force.imag = tangential
    force *= n
    return float(normal @ r)


def drift(m: Motion, dt: float, moving_cell: bool) -> None:
    """x -> (1 + e dt) x + v dt, the cell with it."""
    if moving_cell:
        m.z *= 1 + m.rate * dt
        m.scale *= 1 + m.rate * dt
    m.z += m.v * dt
    if m.outside is not None:
        m.outside.drift(dt)


def kick(
    m: Motion, forces: Forces, drive: Drive, before: float, after: float, rotates: bool
) -> None:
    """Advance velocities by ``before`` explicitly and ``after`` implicitly in the drag."""
    fade = (1 - drive.drag * before) / (1 + drive.drag * after)
    gain = (before + after) / (1 + drive.drag * after)
    m.v *= fade
    m.v += gain * forces.pull / m.mass
    if rotates:
        m.s *= fade
        m.s += 2 * gain * forces.twist / m.mass
    if m.outside is not None and forces.onto is not None:
        m.outside.kick(m.v, m.s, forces.onto, fade, gain)
    if drive.pressure is not None:
        excess = forces.virial - 2 * drive.pressure * m.area * m.scale**2
        m.rate = fade * m.rate + gain * excess / m.total


def advance(
    m: Motion,
    forces: Forces,
    near: Neighbours,
    law: ContactLaw,
    drive: Drive,
    dt: float,
    steps: int,
    drifted: bool,
) -> tuple[int, bool, Forces]:
    """Up to ``steps`` steps; returns early, drifted, when the neighbour list is used up."""
    rotates, moving_cell = law.friction > 0, drive.pressure is not None
    for done in range(steps):
        if not drifted:
            drift(m, dt, moving_cell)
            far = np.abs(m.z - m.scale * near.origin).max()
            if m.outside is not None:
                far = max(far, m.outside.strayed)
            if far >= near.reach(m.scale):
                return done, True, forces
        drifted = False
        forces = contact_forces(m, near, law, dt)
        last = done == steps - 1
        kick(m, forces, drive, 0.0 if last else 0.5 * dt, 0.5 * dt, rotates)
    return steps, False, forces
