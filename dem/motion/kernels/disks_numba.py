"""The compiled twin of ``disks_numpy``: the same formulas, one pair at a time (extra ``fast``).

It knows linear springs and, by a loop of its own (``hertz_loop``), elastic spheres.  A test holds
the two kernels together to round-off over hundreds of steps.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any
from zlib import crc32

import numpy as np
from numba import njit

from dem.model.drive import Drive
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.kernels import outside_loop
from dem.motion.kernels.hertz_loop import hertz_forces
from dem.motion.kernels.motion import Forces, Motion
from dem.motion.kernels.outside_loop import no_act as _act
from dem.motion.kernels.outside_loop import no_kick as _kick
from dem.motion.kernels.outside_loop import no_push as _push
from dem.motion.kernels.outside_loop import no_shift as _shift
from dem.motion.kernels.outside_loop import no_weigh as _weigh
from packing.contact_law import Hertz


def _forces(z, v, s, scale, rate, i, j, shift, sigma, u, k, kt, mu, dashpot, dt, pull, twist):  # type: ignore[no-untyped-def]
    """Fill ``pull`` and ``twist``, advance ``u`` by ``dt``, return the virial Σ f_n r.

    Numbers are of the type of ``s``: a literal would widen float32 to float64.  Divisions cost
    most: there are two a contact, by r and by the turn of the branch within dt/2.
    """
    real = s.dtype.type
    zero, one, half_dt = real(0.0), real(1.0), real(0.5) * dt
    compliance = one / kt if kt > zero else zero
    size, rate = real(scale), real(rate)
    pull[:] = 0.0
    twist[:] = 0.0
    virial = 0.0
    for e in range(len(i)):
        a, b = i[e], j[e]
        d = z[b] - z[a] + shift[e] * size
        r2 = d.real * d.real + d.imag * d.imag
        if r2 >= sigma[e] * sigma[e]:
            u[e] = zero
            continue
        r = np.sqrt(r2)
        inverse = one / r
        n = complex(d.real * inverse, d.imag * inverse)
        normal = k * (sigma[e] - r)
        slip = complex(zero, zero)
        if mu > zero or dashpot > zero:
            slip = (v[b] - v[a]) * n.conjugate()
        if dashpot > zero:
            normal = max(normal - dashpot * (slip.real + rate * r), zero)
        tangential = zero
        if mu > zero:
            turn = s[a] + s[b]
            cap = mu * normal
            stretched = u[e] + dt * (slip.imag / (one - half_dt * slip.real * inverse) - turn)
            tangential = min(max(kt * stretched, -cap), cap)
            u[e] = tangential * compliance
            twist[a] += tangential
            twist[b] += tangential
        f = complex(-normal, tangential) * n
        pull[a] += f
        pull[b] -= f
        virial += normal * r
    return virial


def _advance(  # type: ignore[no-untyped-def]
    z, v, s, per_mass, total, area, scale, rate,
    i, j, shift, sigma, u, origin, skin, smallest, largest,
    k, kt, mu, dashpot, drag, pressure, controlled, dt, steps, drifted, pull, twist, virial,
    outside,
):  # fmt: skip
    real = s.dtype.type
    tick = real(dt)  # the cell moves in float64, the grains in their own precision
    for done in range(steps):
        if not drifted:
            stretch = 1 + rate * dt if controlled else 1.0
            scale *= stretch
            grow, size = real(stretch), real(scale)
            worst = largest if scale < 1 else smallest
            reach = 0.5 * (scale * skin - (1 - scale) * worst)
            far = real(0.0)
            for g in range(len(z)):
                z[g] = z[g] * grow + v[g] * tick
                w = z[g] - size * origin[g]
                far = max(far, w.real * w.real + w.imag * w.imag)
            strayed = _shift(dt, outside)
            if reach <= 0.0 or far >= reach * reach or strayed >= reach * reach:
                return done, True, scale, rate, virial
        drifted = False
        virial = _forces(
            z, v, s, scale, rate, i, j, shift, sigma, u, k, kt, mu, dashpot, tick, pull, twist
        )
        _act(z, v, s, dt, pull, twist, outside)
        before = 0.0 if done == steps - 1 else 0.5 * dt
        fade = (1 - drag * before) / (1 + drag * 0.5 * dt)
        gain = (before + 0.5 * dt) / (1 + drag * 0.5 * dt)
        fading, push = real(fade), real(gain)
        turning = real(2.0) * push
        _push(v, per_mass, pull, fading, push, outside)
        if mu > 0.0:
            for g in range(len(z)):
                s[g] = s[g] * fading + turning * per_mass[g] * twist[g]
        _kick(v, s, fade, gain, outside)
        if controlled:
            rate = fade * rate + gain * (virial - 2 * pressure * area * scale**2) / total
    _weigh(pull, outside)
    return steps, False, scale, rate, virial


def _stamp(*parts: Any) -> int:
    """Of what is compiled into ``_advance``: Numba finds kept code by the file of ``_advance``
    alone, and would not notice that another has changed."""
    codes = (part.__code__ for part in parts)
    return crc32(repr([(c.co_code, c.co_consts, c.co_names) for c in codes]).encode())


@cache
def _compiled(kept: bool, loop: Callable, confined: bool) -> dict[str, Callable]:
    """The loops compiled, with this ``loop`` over pairs, and with what acts from outside if grains
    are ``confined``; ``kept`` on disk for the next process."""
    compile_ = njit(cache=kept, error_model="numpy", fastmath={"contract"})
    o = outside_loop
    outside: tuple[Any, ...] = (o.act, o.kick, o.push, o.shift, o.weigh)
    if not confined:
        outside = (_act, _kick, _push, _shift, _weigh)
    names = ("_forces", "_act", "_kick", "_push", "_shift", "_weigh")
    parts = {k: compile_(part) for k, part in zip(names, (loop, *outside), strict=True)}
    advance = FunctionType(_advance.__code__, globals() | parts)
    advance.__qualname__ += f"_{_stamp(loop, *outside):08x}"
    return {
        "forces": parts["_forces"],
        "act": parts["_act"],
        "weigh": parts["_weigh"],
        "advance": compile_(advance),
    }


_keeps = True


def _run(name: str, loop: Callable, confined: bool, *arguments: Any) -> Any:
    """Call a loop; where machine code cannot be kept, compile it in each process.

    That costs seconds and changes no number: a read-only package and no home, a full disk, a
    damaged file of the cache.  The loops themselves raise nothing, so what is caught here
    comes from keeping or loading them; anything else is raised again by the second call.
    """
    global _keeps
    if _keeps:
        try:
            return _compiled(True, loop, confined)[name](*arguments)
        except Exception:  # a damaged file can raise nearly anything
            _keeps = False
    return _compiled(False, loop, confined)[name](*arguments)


def refuse_law(law: ContactLaw) -> None:
    """ValueError for what are neither linear springs nor elastic spheres."""
    if law.linear is None and not isinstance(law.contact, Hertz):
        raise ValueError(
            f"contact = {law.contact!r}: the compiled kernel knows linear springs and Hertz only; "
            'take backend="numpy"'
        )


def constants(
    m: Motion, near: Neighbours, law: ContactLaw
) -> tuple[Callable, tuple[Any, Any, Any, Any]]:
    """The loop over pairs, and κ, k_t, μ and c_n in the precision in which grains move; of Hertz
    κ √(4R) of each pair, and the ratio of k_t to the slope."""
    real = m.s.dtype.type
    if isinstance(law.contact, Hertz):
        mine = law.contact.of_contacts(near.effective_radii)
        k: Any = np.asarray(mine.strength, m.s.dtype)
        loop, kt = hertz_forces, mine.stiffness_ratio
    else:
        loop, k, kt = _forces, real(law.stiffness), law.tangential
    return loop, (k, real(kt), real(law.friction), real(law.dashpot))


def half_words(near: Neighbours) -> Any:
    """The pairs in int32: half the memory to read in every step."""
    return near.columns.astype(np.uint32)


def contact_forces(m: Motion, near: Neighbours, law: ContactLaw, dt: float) -> Forces:
    """As ``disks_numpy.contact_forces``."""
    pull, twist = np.empty_like(m.z), np.empty_like(m.s)
    i, j = half_words(near)
    loop, numbers = constants(m, near, law)
    confined = m.outside is not None
    virial = _run(
        "forces", loop, confined,
        m.z, m.v, m.s, m.scale, m.rate, i, j, near.shift, near.sigma, near.elongation,
        *numbers, m.s.dtype.type(dt), pull, twist,
    )  # fmt: skip
    found = Forces(pull, twist, float(virial))
    if m.outside is not None:
        found.onto = np.empty(len(m.outside.offsets))
        outside = outside_loop.arrays_of(m.outside, found.onto, 0.0)
        _run("act", loop, confined, m.z, m.v, m.s, dt, pull, twist, outside)
        _run("weigh", loop, confined, pull, outside)
    return found


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
    """As ``disks_numpy.advance``."""
    i, j = half_words(near)
    controlled = drive.pressure is not None
    loop, numbers = constants(m, near, law)
    outside: tuple[Any, ...] = ()
    if m.outside is not None:
        onto = np.zeros(len(m.outside.offsets)) if forces.onto is None else forces.onto
        forces.onto = onto
        outside = outside_loop.arrays_of(m.outside, onto, drive.gravity)
    done, drifted, m.scale, m.rate, virial = _run(
        "advance", loop, bool(outside),
        m.z, m.v, m.s, 1 / m.mass, m.total, m.area, m.scale, m.rate,
        i, j, near.shift, near.sigma, near.elongation,
        near.origin, near.skin, near.smallest, near.largest,
        *numbers, drive.drag, drive.pressure or 0.0, controlled,
        dt, steps, drifted, forces.pull, forces.twist, forces.virial, outside,
    )  # fmt: skip
    return done, drifted, Forces(forces.pull, forces.twist, virial, forces.onto)
