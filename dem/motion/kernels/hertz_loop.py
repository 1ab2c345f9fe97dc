"""The loop over pairs of the compiled kernel for elastic spheres, Hertz and Mindlin.

    f_n = k δ^(3/2),   k_t = ρ 3/2 k √δ,   u ← u √(δ'/δ) where the contact loads from δ' to δ

with k = κ √(4R) of the pair, ρ the ratio of k_t to the slope, and u = f_t/k_t the elongation: what
a contact bears stays as it loads, and falls with k_t as it unloads.  The overlap δ' of a step ago
is that of the branch before the drift.
"""

from __future__ import annotations

import numpy as np


def hertz_forces(z, v, s, scale, rate, i, j, shift, sigma, u, k, kt, mu, dashpot, dt, pull, twist):  # type: ignore[no-untyped-def]
    """As ``disks_numba._forces``, with an array ``k``, and for ``kt`` the ratio."""
    real = s.dtype.type
    zero, one, half_dt = real(0.0), real(1.0), real(0.5) * dt
    size, rate = real(scale), real(rate)
    stiffer = real(1.5) * kt
    shrink = one / (one + rate * dt)
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
        overlap = sigma[e] - r
        slope = k[e] * np.sqrt(overlap)
        normal = slope * overlap
        apart = complex(zero, zero)
        slip = complex(zero, zero)
        if mu > zero or dashpot > zero:
            apart = v[b] - v[a]
            slip = apart * n.conjugate()
        if dashpot > zero:
            normal = max(normal - dashpot * (slip.real + rate * r), zero)
        tangential = zero
        if mu > zero:
            x = (d.real - apart.real * dt) * shrink
            y = (d.imag - apart.imag * dt) * shrink
            before = sigma[e] - np.sqrt(x * x + y * y)
            held = u[e]
            if before < overlap and held != zero:
                held *= np.sqrt(max(before, zero) / overlap)
            turn = s[a] + s[b]
            cap = mu * normal
            stretched = held + dt * (slip.imag / (one - half_dt * slip.real * inverse) - turn)
            spring = stiffer * slope
            tangential = min(max(spring * stretched, -cap), cap)
            u[e] = tangential / spring
            twist[a] += tangential
            twist[b] += tangential
        f = complex(-normal, tangential) * n
        pull[a] += f
        pull[b] -= f
        virial += normal * r
    return virial
