"""Photoelastic disks: can the forces in them be had from what was seen?

By geometry: a gap r - σ that is measured to ξ tells a force to ξ/Δ mean forces, Δ = ⟨f_n⟩/(κ⟨σ⟩).
By balance: forces f_n >= 0, |f_t| <= μ f_n of the contacts that were seen, as even as balance lets
them be,

    min  Σ_e [ (f_n - f̄)²/f̄² + f_t²/(f̄/2)² ]  +  |M f|²/s² ,

M the balance of all grains but those at the rim, which something unseen holds; s the part of the
balance that contacts which were not seen may take (s → 0: none). f̄, the mean, is taken from the
measurement. Every disk measures its own side of a contact: their difference is the noise.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array, hstack, vstack
from scipy.spatial import ConvexHull

from dem import Packing, Scene
from packing.measurement import Measurement
from scaling import CoarseCoordinatesWarning, ContactNetwork, force_equation
from scaling.algebra.quadratic_program import minimise
from studies.packing_store import SEED, cell_of, make
from studies.third_party import third_party

STIFFNESS = 6490.0
"""κ of the disks in N/m, as their group gives it."""
PIXEL = 2.7e-4
"""m."""
RIM = 1.5
"""Grains nearer than this to the hull of all centres, in ⟨σ⟩, are held by what was not seen."""
FRICTIONS = (0.3, 0.5, 1.0)
SLACKS = (1e-3, 0.1, 0.3, 1.0)
"""s, in f̄."""


@dataclass(frozen=True, eq=False)
class Region:
    """Contacts seen, the normal forces measured in them, and the grains that must balance."""

    network: ContactNetwork
    measured: np.ndarray
    inner: np.ndarray

    @property
    def mean(self) -> float:
        """f̄."""
        return float(self.measured.mean())

    def error(self, normal: np.ndarray) -> float:
        """rms(f_n - measured)/f̄ over contacts of which one end at least must balance."""
        held = self.inner[self.network.pairs].any(axis=1)
        return float(np.sqrt(np.mean((normal - self.measured)[held] ** 2)) / self.mean)


def region(positions: np.ndarray, radii: np.ndarray, pairs: np.ndarray, fn: np.ndarray) -> Region:
    """An open network whose grains balance if they are no closer than RIM to the hull."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CoarseCoordinatesWarning)  # that is what is measured here
        network = ContactNetwork(positions, radii, pairs)
    touched = network.degrees > 0
    faces = ConvexHull(positions[touched]).equations
    depth = -(positions @ faces[:, :2].T + faces[:, 2]).max(axis=1)
    inner = touched & (depth > RIM * network.mean_diameter)
    return Region(network, np.asarray(fn), inner)


def by_balance(seen: Region, friction: float, slack: float) -> np.ndarray:
    """(2c,) forces of the program above, s = ``slack`` f̄."""
    n, c, mean = seen.network, seen.network.contacts, seen.mean
    equation = force_equation(n)
    grain = equation.rows["index"][: equation.M.shape[0]]
    balance = csr_array(equation.M)[np.flatnonzero(seen.inner[grain])]
    m = balance.shape[0]
    P = np.concatenate([np.ones(c), np.full(c, 4.0), np.full(m, slack**-2.0)])
    q = np.concatenate([-np.ones(c), np.zeros(c + m)])
    unit, none = eye_array(c), csr_array((c, m))
    cone = [
        hstack([-unit, csr_array((c, c)), none]),
        hstack([-friction * unit, unit, none]),
        hstack([-friction * unit, -unit, none]),
    ]
    equal = hstack([balance, -diags_array(np.ones(m))])
    z, _ = minimise(P, q, equal, np.zeros(m), vstack(cone))
    return mean * z[: 2 * c]


def geometry(data: Measurement) -> dict[str, float]:
    """What gaps and forces of the set say of each other."""
    assert data.pairs is not None
    assert data.radii is not None
    assert data.normal_forces is not None
    assert data.uncertainty.normal_forces is not None
    i, j = data.pairs.T
    sides = np.asarray(data.uncertainty.normal_forces)
    unit = 2 * data.radii.mean()
    r = np.hypot(*(data.positions[j] - data.positions[i]).T)
    gaps, fn = (r - data.radii[i] - data.radii[j]) / unit, data.normal_forces
    overlaps = fn / (STIFFNESS * unit * PIXEL)
    from_gaps = -(gaps - gaps.mean())
    off = from_gaps - (overlaps - overlaps.mean())
    return {
        "contacts": float(len(fn)),
        "delta": float(overlaps.mean()),
        "strongest": float(np.quantile(overlaps, 0.95)),
        "gap": float(gaps.mean()),
        "xi": float(gaps.std()),
        "error": float(np.sqrt(np.mean(off**2)) / overlaps.mean()),
        "correlation": float(np.corrcoef(from_gaps, overlaps)[0, 1]),
        "two_sided": float(np.sqrt(np.mean(np.square(sides))) / fn.mean()),
        "spread": float(fn.std() / fn.mean()),
    }


def own(friction: float = 0.5) -> Packing:
    """A packing of ours of about as many disks and their Δ."""
    return make([Scene(900, 1e-3, friction=friction)], [1])[0]


def own_region(p: Packing, lost: float, noise: float) -> Region:
    """The same of ours: what crosses the cell cut, the weakest part ``lost`` of its contacts not
    seen, its forces measured with ``noise`` f̄."""
    cell = cell_of(p)
    jump = np.floor(p.positions @ np.linalg.inv(cell))
    i, j = p.pairs.T
    inside = ~(p.images + jump[j] - jump[i]).any(axis=1)
    seen = inside & (p.normal_forces >= np.quantile(p.normal_forces[inside], lost))
    rng = np.random.default_rng(SEED)
    fn = p.normal_forces[seen]
    fn = fn + noise * fn.mean() * rng.standard_normal(len(fn))
    return region(p.positions - jump @ cell, p.radii, p.pairs[seen], fn)


def lines() -> Iterator[str]:
    """Both parts as tables."""
    data = third_party("photoelastic_shear")
    assert isinstance(data, Measurement)
    assert data.radii is not None
    assert data.pairs is not None
    assert data.normal_forces is not None
    g = geometry(data)
    yield "| by geometry | |"
    yield "|---|---|"
    yield f"| contacts with a force | {g['contacts']:.0f} |"
    Δ, strongest, ξ = g["delta"], g["strongest"], g["xi"]
    yield f"| Δ = ⟨f_n⟩/(κ⟨σ⟩), and of the strongest 5 % | {Δ:.1e}, {strongest:.1e} |"
    yield f"| mean gap, and its scatter ξ, in ⟨σ⟩ | {g['gap']:.3f}, {ξ:.4f} |"
    yield f"| ξ/Δ, and of the strongest 5 % | {ξ / Δ:.0f}, {ξ / strongest:.0f} |"
    yield f"| E of f_n = κ (σ - r), mean gap taken out | {g['error']:.0f} |"
    yield f"| correlation of overlap and force | {g['correlation']:.2f} |"
    yield f"| noise of f_n, from its two sides | {g['two_sided']:.2f} |"
    yield f"| E of all f_n equal | {g['spread']:.2f} |\n"
    p, noise = own(), g["two_sided"]
    cases = {
        "photoelastic": region(data.positions, data.radii, data.pairs, data.normal_forces),
        "own, all contacts": own_region(p, 0.0, noise),
        "own, weakest 20 % unseen": own_region(p, 0.2, noise),
    }
    head = " | ".join(f"s = {s:g} f̄" for s in SLACKS)
    yield f"| packing | Z | μ told | all equal | {head} | noise |"
    yield "|---" * (5 + len(SLACKS)) + "|"
    for name, seen in cases.items():
        flat = seen.error(np.full(seen.network.contacts, seen.mean))
        for μ in FRICTIONS:
            cells = [_cell(seen, μ, s) for s in SLACKS]
            yield (
                f"| {name} | {seen.network.coordination:.2f} | {μ:g} | {flat:.2f} | "
                f"{' | '.join(cells)} | {noise:.2f} |"
            )


def _cell(seen: Region, friction: float, slack: float) -> str:
    """E of the normal forces by balance, or that it is refused."""
    try:
        found = by_balance(seen, friction, slack)
    except (ValueError, RuntimeError):
        return "refused"
    return f"{seen.error(found[: seen.network.contacts]):.2f}"
