"""The compiled twin of ``outside``: weight and walls, one contact at a time.

Between two looks weight is an acceleration, the same for all, and added where velocities are: an
array of weights would have to be read in every step, which at a thousand grains costs a tenth of
it. A scene without walls and weight runs the functions ``no_...``, which cost nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dem.motion.kernels.outside import Outside
from packing.contact_law import Hertz


def act(z, v, s, dt, pull, twist, o):  # type: ignore[no-untyped-def]
    """As ``Outside.act`` without the weight, see ``weigh``; ``onto`` is filled."""
    n, offsets, speeds, _, _, grains, walls, radii, u, _, stuck, stuck_to, _, onto = o[:14]
    hertz, k, kt, mu, dashpot, _ = o[14:]
    onto[:] = 0.0
    for e in range(len(grains)):
        g, w = grains[e], walls[e]
        m = n[w].conjugate()
        gap = offsets[w] - (z[g] * m).real - radii[e]
        if gap >= 0.0:
            u[e] = 0.0
            continue
        slip = -v[g] * m
        approach = slip.real + speeds[w]
        slope = k[e] * np.sqrt(-gap) if hertz else k[e]
        normal = -slope * gap
        if dashpot > 0.0:
            normal = max(normal - dashpot * approach, 0.0)
        tangential = 0.0
        if mu > 0.0:
            held, spring = u[e], kt * k[e]
            if hertz:
                before = dt * approach - gap
                if before < -gap and held != 0.0:
                    held *= np.sqrt(max(before, 0.0) / -gap)
                spring = 1.5 * kt * slope
            cap = mu * normal
            tangential = min(max(spring * (held + dt * (slip.imag - s[g])), -cap), cap)
            u[e] = tangential / spring
            twist[g] += tangential
        pull[g] += complex(-normal, tangential) * n[w]
        onto[w] += normal
    for e in range(len(stuck)):
        g, w = stuck[e], stuck_to[e]
        onto[w] += (pull[g] * n[w].conjugate()).real
        pull[g] = 0.0
        twist[g] = 0.0


def weigh(pull, o):  # type: ignore[no-untyped-def]
    """Add the weight to forces that are handed on."""
    weight = o[12]
    for g in range(len(weight)):
        pull[g] += weight[g]


def push(v, per_mass, pull, fade, gain, o):  # type: ignore[no-untyped-def]
    """Velocities of grains, under their weight."""
    fall = complex(0.0, -gain * o[19])
    for g in range(len(v)):
        v[g] = v[g] * fade + (gain * per_mass[g] * pull[g] + fall)


def kick(v, s, fade, gain, o):  # type: ignore[no-untyped-def]
    """As ``Outside.kick``."""
    n, _, speeds, per_mass, load, _, _, _, _, _, stuck, stuck_to, _, onto = o[:14]
    for w in range(len(speeds)):
        speeds[w] = speeds[w] * fade + gain * per_mass[w] * (onto[w] - load[w])
    for e in range(len(stuck)):
        v[stuck[e]] = speeds[stuck_to[e]] * n[stuck_to[e]]
        s[stuck[e]] = 0.0


def shift(dt, o):  # type: ignore[no-untyped-def]
    """The walls move on; the square of the furthest that one is from where it was listed."""
    offsets, speeds, start = o[1], o[2], o[9]
    far = 0.0
    for w in range(len(offsets)):
        offsets[w] += speeds[w] * dt
        far = max(far, (offsets[w] - start[w]) ** 2)
    return far


def no_push(v, per_mass, pull, fade, gain, o):  # type: ignore[no-untyped-def]
    """Velocities of grains."""
    for g in range(len(v)):
        v[g] = v[g] * fade + gain * per_mass[g] * pull[g]


def no_weigh(pull, o):  # type: ignore[no-untyped-def]
    """Nothing weighs."""


def no_act(z, v, s, dt, pull, twist, o):  # type: ignore[no-untyped-def]
    """Nothing acts."""


def no_kick(v, s, fade, gain, o):  # type: ignore[no-untyped-def]
    """There is no wall."""


def no_shift(dt, o):  # type: ignore[no-untyped-def]
    """There is no wall."""
    return 0.0


def arrays_of(outside: Outside, onto: np.ndarray, gravity: float) -> tuple[Any, ...]:
    """What the loops are given; ``onto`` is theirs to fill."""
    law, o = outside.law, outside
    if isinstance(law.contact, Hertz):
        k = np.broadcast_to(law.contact.of_contacts(o.radii).strength, o.radii.shape)
        hertz, kt = True, law.contact.stiffness_ratio
    else:
        k, hertz, kt = np.full(o.radii.shape, law.stiffness), False, law.stiffness_ratio
    return (
        o.normals, o.offsets, o.speeds, o.per_mass, o.load, o.grains, o.walls, o.radii,
        o.elongation, o.start, o.stuck, o.stuck_to, o.weight, onto,
        hertz, np.ascontiguousarray(k, float), float(kt), law.friction, law.dashpot,
        gravity,
    )  # fmt: skip
