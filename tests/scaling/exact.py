"""Eq. 1 of a small periodic packing in 60 digits, from the saved high and low parts."""

from __future__ import annotations

import mpmath

from dem import Packing
from scaling import ContactNetwork

DIGITS = 60
Row = list[mpmath.mpf]


def branches(p: Packing, network: ContactNetwork) -> tuple[list[Row], list[mpmath.mpf]]:
    """Unit vectors n of the contacts of ``p``, and their size sums σ in ``network``."""
    mp = mpmath.mpf
    low = (p.positions * 0 if p.positions_low is None else p.positions_low).tolist()
    cell_low = p.cell * 0 if p.cell_low is None else p.cell_low
    x = [
        [mp(h) + mp(t) for h, t in zip(high, rest, strict=True)]
        for high, rest in zip(p.positions.tolist(), low, strict=True)
    ]
    side = [mp(p.cell[k, k]) + mp(cell_low[k, k]) for k in (0, 1)]
    sizes = network.radii, network.radii * 0
    if network.extended is not None:
        sizes = network.extended.radii.high, network.extended.radii.low
    radii = [mp(h) + mp(t) for h, t in zip(*(s.tolist() for s in sizes), strict=True)]
    normals, sigma = [], []
    for (i, j), m in zip(p.pairs.tolist(), p.images.tolist(), strict=True):
        d = [x[j][k] - x[i][k] + m[k] * side[k] for k in (0, 1)]
        r = mpmath.sqrt(d[0] ** 2 + d[1] ** 2)
        normals.append([d[0] / r, d[1] / r])
        sigma.append(radii[i] + radii[j])
    return normals, sigma


def loops(network: ContactNetwork) -> list[list[tuple[int, int]]]:
    """Contacts of each face with their direction of travel."""
    m = network.loops.incidence.tocsr()
    return [
        [(int(m.indices[q]), int(m.data[q])) for q in range(m.indptr[a], m.indptr[a + 1])]
        for a in range(m.shape[0])
    ]


def exact_sums(p: Packing, network: ContactNetwork) -> list[mpmath.mpf]:
    """Q|σ⟩ of every face, x then y."""
    with mpmath.workdps(DIGITS):
        n, sigma = branches(p, network)
        return [
            sum(s * n[e][k] * sigma[e] for e, s in loop) for k in (0, 1) for loop in loops(network)
        ]


def exact_forces(p: Packing, network: ContactNetwork) -> list[mpmath.mpf]:
    """(f_n ; f_t), or f_n without friction: the least squares solution of Eq. 1."""
    with mpmath.workdps(DIGITS):
        n, sigma = branches(p, network)
        count, frictional = len(n), p.friction > 0
        rows: list[dict[int, mpmath.mpf]] = [{} for _ in range(3 * len(p.radii))]
        for e, (i, j) in enumerate(p.pairs.tolist()):
            x, y = n[e]
            for grain, sign in ((i, 1), (j, -1)):
                rows[3 * grain][e] = -sign * x
                rows[3 * grain + 1][e] = -sign * y
                if frictional:  # t = n turned by +90 degrees
                    rows[3 * grain][count + e] = -sign * y
                    rows[3 * grain + 1][count + e] = sign * x
                    rows[3 * grain + 2][count + e] = mpmath.mpf(1)
        rhs = [mpmath.mpf(0)] * len(rows)
        for loop in loops(network):
            for k in (0, 1):
                rows.append({e: s * n[e][k] for e, s in loop})
                rhs.append(p.stiffness * sum(s * n[e][k] * sigma[e] for e, s in loop))
        size = count * (2 if frictional else 1)
        A, b = mpmath.zeros(size), mpmath.zeros(size, 1)
        for row, value in zip(rows, rhs, strict=True):
            for e, g in row.items():
                b[e] += g * value
                for h, w in row.items():
                    A[e, h] += g * w
        return list(mpmath.lu_solve(A, b))
