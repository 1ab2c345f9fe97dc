"""Packings as hypothesis draws them, named by their physics.

``clusters`` are grown disk by disk and shrink to three touching disks, a triangle;
``scenes`` are small DEM packings, cached, and shrink to the fewest grains a cell can hold;
``worlds`` are such packings in a periodic cell, between walls, or under their weight, of linear
springs or of elastic spheres, and shrink to a periodic cell of linear springs.
"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from dem import Packing
from scaling import ContactNetwork
from tests.conftest import packing
from tests.scaling.networks import Truth, loaded
from tests.scaling.worlds import WORLDS, packing_in

DELTAS = (1e-2, 1e-1, 1e-3, 1e-4, 1e-5)
GRAINS, SEEDS = (20, 26, 36, 48), 5
FRICTIONS, SPREADS = (0.3, 0.0, 0.1, 1.0), (0.3, 0.1, 0.2, 0.4)
seeds = st.integers(0, 2**32 - 1)
size_noises = st.sampled_from(["diameter", "radius", "relative"])


@st.composite
def scenes(draw: st.DrawFn) -> dict:
    """Grain number, friction, polydispersity and seed of a small packing; Δ apart."""
    return {
        "grains": draw(st.sampled_from(GRAINS)),
        "friction": draw(st.sampled_from(FRICTIONS)),
        "polydispersity": draw(st.sampled_from(SPREADS)),
        "seed": draw(st.integers(0, SEEDS - 1)),
    }


@st.composite
def packings(draw: st.DrawFn) -> Packing:
    """A relaxed periodic packing of 20 to 48 disks."""
    return packing(delta=draw(st.sampled_from(DELTAS)), **draw(scenes()))


@st.composite
def worlds(draw: st.DrawFn, laws: tuple[str, ...] = ("linear", "hertz")) -> Packing:
    """A relaxed packing of 30 disks in any of the worlds, μ = 0.3."""
    return packing_in(
        draw(st.sampled_from(tuple(WORLDS))),
        draw(st.sampled_from((1e-2, 1e-3, 1e-4))),
        draw(st.sampled_from(laws)),
        draw(st.integers(1, 2)),
        grains=30,
    )


@st.composite
def clusters(draw: st.DrawFn, most: int = 12) -> Truth:
    """Disks grown on the outside of a triangle, squeezed by Δ; truth first.

    Each new disk touches the two of an outer pair.  Then the plane shrinks by 1 - Δ and every
    disk is displaced by a fraction of Δ; forces follow from the overlaps, loads from the forces.
    """
    count = draw(st.integers(3, most))
    radius = st.floats(0.35, 0.65)
    delta = 10.0 ** draw(st.integers(-6, -1))
    rng = np.random.default_rng(draw(st.integers(0, 999)))
    radii = [draw(radius) for _ in range(3)]
    centres = [0j, complex(radii[0] + radii[1])]
    centres.append(_touching(centres[1], centres[0], radii[1], radii[0], radii[2]))
    pairs, rim = [(0, 1), (1, 2), (0, 2)], [(1, 0), (2, 1), (0, 2)]
    for k in range(3, count):
        r = draw(radius)
        for a, b in list(rim):
            z = _touching(centres[a], centres[b], radii[a], radii[b], r)
            gaps = [abs(z - c) - r - s for c, s in zip(centres, radii, strict=True)]
            if min(g for n, g in enumerate(gaps) if n not in (a, b)) > 1e-3:
                break
        else:
            break
        centres.append(z)
        radii.append(r)
        pairs += [(a, k), (b, k)]
        rim.remove((a, b))
        rim += [(a, k), (k, b)]
    z = np.array(centres) * (1 - delta)
    z = z + 0.1 * delta * (rng.uniform(-1, 1, len(z)) + 1j * rng.uniform(-1, 1, len(z)))
    ordered = np.sort(np.array(pairs), axis=1)
    network = ContactNetwork(np.column_stack([z.real, z.imag]), np.array(radii), ordered)
    return loaded(network, seed=int(rng.integers(2**31)))


def _touching(a: complex, b: complex, ra: float, rb: float, r: float) -> complex:
    """Centre of a disk of radius r that touches both, to the right of the way from a to b."""
    base, p, q = abs(b - a), ra + r, rb + r
    along = (base**2 + p**2 - q**2) / (2 * base)
    return a + (b - a) / base * (along - 1j * np.sqrt(p**2 - along**2))
