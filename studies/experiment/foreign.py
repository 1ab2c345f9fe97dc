"""A packing of another group beside three of ours: does noise cost the same?

The frictional set (N = 1024, μ = 0.1, slow shear) and packings of ours of the same μ, Δ and spread
of the radii, whose Z comes out as it comes. Noise ξ from 0.1 Δ to 30 Δ is added to diameters,
directions exact, or to positions. E is taken against the forces in the file, which balance to
2e-5 ⟨f_n⟩.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from dem import Packing, Scene
from packing.record import Packing as Record
from scaling import (
    ContactNetwork,
    amplification_of,
    gain,
    mean_force,
    perturb,
    reconstruct,
    relative_error,
    stress,
)
from studies.error_bars import one_digit
from studies.packing_store import SEED, make
from studies.third_party import third_party

RATIOS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
METHODS = ("gppsz", "balanced", "direct", "optimal", "bounded")
LARGEST = 0.06
"""ξ in mean diameters up to which noise leaves disks."""
OWN = 3


def beside(theirs: Packing, count: int = OWN) -> list[Packing]:
    """Ours of their μ, Δ, N and spread of the radii, uniform."""
    spread = round(float(np.ptp(theirs.radii) / (2 * theirs.radii.mean())), 2)
    scene = Scene(len(theirs.radii), theirs.delta, friction=theirs.friction, polydispersity=spread)
    return make([scene] * count, range(1, count + 1))


def errors(
    p: Packing, ratios: Sequence[float] = RATIOS, methods: Sequence[str] = METHODS
) -> dict[tuple[str, float, str], float]:
    """E by noise, ξ/Δ and method, one draw each; NaN where the method refuses."""
    network, found = ContactNetwork.from_packing(p), {}
    for noise in ("diameter", "position"):
        for ratio in ratios:
            xi = ratio * p.delta
            if xi > LARGEST:
                continue
            noisy = perturb(network, xi, np.random.default_rng(SEED), noise)
            for method in methods:
                found[noise, ratio, method] = _error(noisy, p, method, noise, xi)
    return found


def _error(noisy: ContactNetwork, p: Packing, method: str, noise: str, xi: float) -> float:
    told: dict[str, Any] = {}
    if method in ("optimal", "bounded"):
        told = {"xi": xi, "noise": noise}
        if noise == "diameter":
            told["data"] = "sizes"
    if method == "bounded":
        told |= {"friction": _limit(p), "pressure": p.pressure, "progress": False}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        try:
            return relative_error(reconstruct(noisy, p.stiffness, method, **told), p)
        except (ValueError, RuntimeError):
            return float("nan")


def _limit(p: Packing) -> float:
    """The limit that no contact exceeds: μ, or what viscous parts of the forces take it to."""
    fn = p.normal_forces
    pressed = fn > 1e-3 * fn.mean()
    return max(p.friction, float(np.max(np.abs(p.tangential_forces[pressed]) / fn[pressed])))


def lines() -> Iterator[str]:
    """Their E, and the mean and standard deviation of ours."""
    theirs = third_party("henkes_dem")
    assert isinstance(theirs, Record)
    ours = beside(theirs)
    yield "| | μ | Δ | Z | K/⟨σ⟩ | p⟨σ⟩/⟨f⟩ | shear | C, diameters | C, positions |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, p in (("theirs", theirs), *((f"ours {k + 1}", p) for k, p in enumerate(ours))):
        C = [f"{amplification_of(p, noise=noise):.3f}" for noise in ("diameter", "position")]
        yield (
            f"| {name} | {p.friction:g} | {p.delta:.2e} | {p.coordination:.2f} | {_parts(p)} | "
            f"{C[0]} | {C[1]} |"
        )
    yield ""
    of_theirs, of_ours = errors(theirs), [errors(p) for p in ours]
    head = " | ".join(f"ξ = {r:g} Δ" for r in RATIOS)
    yield f"| noise | method | {head} |"
    yield "|---" * (2 + len(RATIOS)) + "|"
    for noise in ("diameter", "position"):
        for method in METHODS:
            cells = [_cell(of_theirs, of_ours, (noise, ratio, method)) for ratio in RATIOS]
            yield f"| {noise} | {method} | {' | '.join(cells)} |"


def _parts(p: Packing) -> str:
    """The two factors of C on diameters, and |σ_xx - σ_yy, 2 σ_xy|/2p: how sheared it is."""
    network = ContactNetwork.from_packing(p)
    unit, σ = network.mean_diameter, stress(network, p.forces)
    K, f = gain(network, "gppsz", "diameter") / unit, p.pressure * unit / mean_force(p)
    shear = np.hypot(σ[0, 0] - σ[1, 1], σ[0, 1] + σ[1, 0]) / (2 * p.pressure)
    return f"{K:.3f} | {f:.3f} | {shear:.3f}"


def _cell(
    theirs: dict[tuple[str, float, str], float],
    ours: list[dict[tuple[str, float, str], float]],
    key: tuple[str, float, str],
) -> str:
    """Theirs, then ours ± their standard deviation."""
    if key not in theirs:
        return ""
    values = np.array([one[key] for one in ours if key in one])
    values = values[np.isfinite(values)]
    mine = f"{theirs[key]:.3g}" if np.isfinite(theirs[key]) else "refused"
    if len(values) < 2:
        return f"{mine} (ours refused)"
    return f"{mine} ({values.mean():.3g} ± {one_digit(values.std(ddof=1))})"
