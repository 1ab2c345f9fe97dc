"""E of a wrong stiffness: by one factor, spread over contacts, in the contact law."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from dem import Packing, Scene
from scaling import forces_of_overlaps, reconstruct, relative_error, to_pressure
from studies.open_regions import without_dangling
from studies.packing_store import SEED, cell_of, make, net

STIFFNESS_AT = (1e-1, 1e-2, 1e-4)
ERROR = 0.1


def lines() -> Iterator[str]:
    """E of a wrong stiffness: by one factor, spread over contacts, in the contact law."""
    yield f"All for s = ε = {ERROR:g}; three packings of N = 300, or regions of them.\n"
    yield (
        "| Δ | estimator | factor, no loads | pressure used | factor, known loads | share f_L/f"
        " | spread | Hertz, pressure used |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for d in STIFFNESS_AT:
        some = make([Scene(300, d)] * 3, range(3))
        for method in ("gppsz", "balanced", "direct"):
            v = np.array([_wrong_stiffness(p, method) for p in some])
            cells = [f"{x.mean():.3f} ± {x.std(ddof=1):.3f}" for x in v.T]
            yield f"| {d:g} | {method} | " + " | ".join(cells) + " |"
        for method in ("optimal", "bounded"):
            v = np.array([_weighed(p, method) for p in some])
            yield f"| {d:g} | {method} | {v.mean():.3f} ± {v.std(ddof=1):.3f} | | | | | |"


def _wrong_stiffness(p: Packing, method: str) -> tuple[float, ...]:
    n, κ, true = net(p), p.stiffness, p.forces
    δ = p.normal_forces / κ

    def error(overlaps: np.ndarray, factor: float = 1.0, scaled: bool = False) -> float:
        found = forces_of_overlaps(n, overlaps, factor * κ, method)
        return relative_error(to_pressure(n, found, p.pressure) if scaled else found, p)

    spread = δ / (1 + ERROR * np.random.default_rng(SEED).uniform(-1, 1, len(δ)) * np.sqrt(3))
    cell = cell_of(p)
    centre = cell.sum(axis=0) / 2
    mask = np.linalg.norm(p.positions - centre, axis=1) < cell[0, 0] / 2.2
    region = without_dangling(n, mask, true.reshape(2, -1))
    f = true.reshape(2, -1)[:, region.contact_index].ravel()
    own = f[: region.contacts] / κ
    with_loads = forces_of_overlaps(region, own, (1 + ERROR) * κ, method)
    loops = (with_loads - forces_of_overlaps(region, own, κ, method)) / ERROR
    return (
        error(δ, 1 + ERROR), error(δ, 1 + ERROR, True),
        relative_error(with_loads, f, frictional=True),
        float(np.linalg.norm(loops) / np.linalg.norm(f)), error(spread),
        error(δ ** (2 / 3), 1, True),
    )  # fmt: skip


def _weighed(p: Packing, method: str) -> float:
    """E of `optimal` or `bounded` for κ wrong by one factor, data exact but taken as ξ = 0.1 Δ."""
    more: dict[str, Any] = (
        {"friction": p.friction, "pressure": p.pressure} if method == "bounded" else {}
    )
    κ, xi = (1 + ERROR) * p.stiffness, 0.1 * p.delta
    found = reconstruct(net(p), κ, method, xi=xi, noise="position", **more)
    return relative_error(found, p)
