"""The compiled twin of ``numpy_kernel``: the same formulas, one pair at a time (extra ``fast``).

A test holds the two together to round-off over hundreds of steps.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from dem.law import ContactLaw, Drive
from dem.neighbours import Neighbours
from dem.numpy_kernel import Forces, Motion


@njit(cache=True, error_model="numpy")
def _forces(z, v, s, scale, rate, i, j, shift, sigma, u, k, kt, mu, dashpot, dt, pull, twist):  # type: ignore[no-untyped-def]
    """Fill ``pull`` and ``twist``, advance ``u`` by ``dt``, return the virial Σ f_n r."""
    pull[:] = 0.0
    twist[:] = 0.0
    virial = 0.0
    for e in range(len(i)):
        a, b = i[e], j[e]
        d = z[b] - z[a] + shift[e] * scale
        r2 = d.real * d.real + d.imag * d.imag
        if r2 >= sigma[e] * sigma[e]:
            u[e] = 0.0
            continue
        r = np.sqrt(r2)
        n = complex(d.real / r, d.imag / r)
        normal = k * (sigma[e] - r)
        slip = 0j
        if mu > 0.0 or dashpot > 0.0:
            slip = (v[b] - v[a]) * n.conjugate()
        if dashpot > 0.0:
            normal = max(normal - dashpot * (slip.real + rate * r), 0.0)
        tangential = 0.0
        if mu > 0.0:
            turn = s[a] + s[b]
            cap = mu * normal
            stretched = u[e] + dt * (slip.imag / (1 - 0.5 * dt * slip.real / r) - turn)
            tangential = min(max(kt * stretched, -cap), cap)
            u[e] = tangential / kt
            twist[a] += tangential
            twist[b] += tangential
        f = complex(-normal, tangential) * n
        pull[a] += f
        pull[b] -= f
        virial += normal * r
    return virial


@njit(cache=True, error_model="numpy")
def _advance(  # type: ignore[no-untyped-def]
    z, v, s, mass, total, area, scale, rate, i, j, shift, sigma, u, origin, skin, largest,
    k, kt, mu, dashpot, drag, pressure, controlled, dt, steps, drifted, pull, twist, virial,
):  # fmt: skip
    for done in range(steps):
        if not drifted:
            stretch = 1 + rate * dt if controlled else 1.0
            scale *= stretch
            reach = 0.5 * (scale * skin - (1 - scale) * largest)
            far = 0.0
            for g in range(len(z)):
                z[g] = z[g] * stretch + v[g] * dt
                w = z[g] - scale * origin[g]
                far = max(far, w.real * w.real + w.imag * w.imag)
            if reach <= 0.0 or far >= reach * reach:
                return done, True, scale, rate, virial
        drifted = False
        virial = _forces(
            z, v, s, scale, rate, i, j, shift, sigma, u, k, kt, mu, dashpot, dt, pull, twist
        )
        before = 0.0 if done == steps - 1 else 0.5 * dt
        fade = (1 - drag * before) / (1 + drag * 0.5 * dt)
        gain = (before + 0.5 * dt) / (1 + drag * 0.5 * dt)
        for g in range(len(z)):
            v[g] = v[g] * fade + gain * pull[g] / mass[g]
        if mu > 0.0:
            for g in range(len(z)):
                s[g] = s[g] * fade + 2 * gain * twist[g] / mass[g]
        if controlled:
            rate = fade * rate + gain * (virial - 2 * pressure * area * scale**2) / total
    return steps, False, scale, rate, virial


def contact_forces(m: Motion, near: Neighbours, law: ContactLaw, dt: float) -> Forces:
    """As ``numpy_kernel.contact_forces``."""
    pull, twist = np.empty_like(m.z), np.empty_like(m.s)
    i, j = near.columns
    virial = _forces(
        m.z, m.v, m.s, m.scale, m.rate, i, j, near.shift, near.sigma, near.elongation,
        law.stiffness, law.tangential, law.friction, law.dashpot, dt, pull, twist,
    )  # fmt: skip
    return Forces(pull, twist, float(virial))


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
    """As ``numpy_kernel.advance``."""
    i, j = near.columns
    controlled = drive.pressure is not None
    done, drifted, m.scale, m.rate, virial = _advance(
        m.z, m.v, m.s, m.mass, m.total, m.area, m.scale, m.rate,
        i, j, near.shift, near.sigma, near.elongation, near.origin, near.skin, near.largest,
        law.stiffness, law.tangential, law.friction, law.dashpot,
        drive.drag, drive.pressure or 0.0, controlled,
        dt, steps, drifted, forces.pull, forces.twist, forces.virial,
    )  # fmt: skip
    return done, drifted, Forces(forces.pull, forces.twist, virial)
