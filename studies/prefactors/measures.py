"""The Comment's 0.3 against two readings of its noise and three of its error.

Noise ξ⟨σ⟩ on diameters, or on radii; the rms error per force component over ⟨|f|⟩, √(⟨δf_n² +
δf_t²⟩/2); per contact vector, √⟨δf_n² + δf_t²⟩, √2 times as large; or of the normal forces alone,
√⟨δf_n²⟩/⟨f_n⟩. All from the exact error map of gppsz, without draws.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from dem import Packing, Scene
from packing.arguments.arrays import Floats
from scaling import error_map
from scaling.uncertainty.relative_error import mean_force
from studies.packing_store import make, net

MEASURES = ("component", "vector", "normal")
CASES = [(d, 0.3) for d in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)]
CASES += [(1e-4, mu) for mu in (0.1, 1.0)]


def prefactors(p: Packing, noise: str = "diameter") -> Floats:
    """C of gppsz, one for each of `MEASURES`."""
    n = net(p)
    squares, c = error_map(n, noise=noise).matrix ** 2, n.contacts
    of_normal, of_all = squares[:c].sum() / c, squares.sum() / c
    f, f_n = mean_force(p.forces), float(np.mean(p.normal_forces))
    return p.pressure * np.array(
        [np.sqrt(of_all / 2) / f, np.sqrt(of_all) / f, np.sqrt(of_normal) / f_n]
    )


def lines(
    cases: Sequence[tuple[float, float]] = CASES, grains: int = 300, packings: int = 8
) -> Iterator[str]:
    """C, mean ± standard deviation over packings."""
    columns = [f"{noise}: {m}" for noise in ("diameters", "radii") for m in MEASURES]
    yield "| Δ | μ | Z | " + " | ".join(columns) + " |\n|---|---|---|" + "---|" * 6
    for delta, mu in cases:
        some = make([Scene(grains, delta, friction=mu)] * packings, range(600, 600 + packings))
        values = np.array([np.concatenate([prefactors(p), prefactors(p, "radius")]) for p in some])
        cells = [f"{m:.3f} ± {s:.3f}" for m, s in zip(
            values.mean(axis=0), values.std(axis=0, ddof=1), strict=True)]  # fmt: skip
        Z = np.array([net(p).coordination for p in some])
        first = f"| {delta:g} | {mu:g} | {Z.mean():.2f} ± {Z.std(ddof=1):.2f} | "
        yield first + " | ".join(cells) + " |"
