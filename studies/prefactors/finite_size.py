"""K²/ℓ and C over N, and the b of their growth 1 + b/N towards small packings.

The faces of a periodic packing are c - N loops, and two more wind the cell. G leaves these out, so
it misses two of c - N + 2 loops: K²/ℓ grows as 1 + b/N for want of them. With `winding=True` they
are in. C = K p/⟨|f|⟩ has the coordination and p/⟨|f|⟩ in it, which change with N too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from dem import Packing, Scene
from packing.arguments.arrays import Floats
from scaling import ContactNetwork, force_equation, gain, relative_error
from scaling.noise.conventions import size_response
from scaling.uncertainty.relative_error import mean_force
from studies.error_bars import bar
from studies.packing_store import SEED, make, net

QUANTITIES = ("K²/ℓ, faces", "K²/ℓ, faces and windings", "the same, ℓ = (c - N + 2)/c",
              "C, faces", "C, faces and windings")  # fmt: skip
COUNTS = {50: 48, 100: 24, 300: 16, 1000: 8, 3000: 4}
"""Packings of each N."""


def lines(
    counts: dict[int, int] = COUNTS, deltas: Sequence[float] = (1e-2, 1e-3, 1e-4)
) -> Iterator[str]:
    """`QUANTITIES` over N, and the fit a (1 + b/N); ± are standard errors over packings, that of b
    multiplied by √(χ² per degree of freedom) where that exceeds 1."""
    yield "| Δ | | " + " | ".join(f"N = {n}" for n in counts) + " | b | χ²/dof |"
    yield "|---|---|" + "---|" * (len(counts) + 2)
    for delta in deltas:
        found = {n: measured(delta, n, range(400, 400 + k)) for n, k in counts.items()}
        for q, name in enumerate(QUANTITIES):
            some = [v[:, q] for v in found.values()]
            means = np.array([v.mean() for v in some])
            errors = np.array([v.std(ddof=1) / np.sqrt(len(v)) for v in some])
            b, error, reduced = growth(np.array(list(counts)), means, errors)
            cells = " | ".join(bar(v) for v in some)
            yield f"| {delta:g} | {name} | {cells} | {b:.1f} ± {error:.1f} | {reduced:.1f} |"
    yield from common_mode(counts)


def common_mode(
    counts: dict[int, int] = COUNTS, deltas: Sequence[float] = (1e-2, 1e-4)
) -> Iterator[str]:
    """What all sizes too large by the same ε do: E/ε with faces alone, E Δ/ε with the windings."""
    yield "\n| Δ | G | " + " | ".join(f"N = {n}" for n in counts) + " |"
    yield "|---|---|" + "---|" * len(counts)
    for delta in deltas:
        found = {}
        for n, k in counts.items():
            packings = make([Scene(n, delta)] * k, range(400, 400 + k))
            found[n] = np.array([[_swollen(p, w) for w in (False, True)] for p in packings])
        faces = [bar(v[:, 0]) for v in found.values()]
        around = [bar(v[:, 1] * delta) for v in found.values()]
        yield f"| {delta:g} | E/ε, faces | " + " | ".join(faces) + " |"
        yield f"| {delta:g} | E Δ/ε, faces and windings | " + " | ".join(around) + " |"


def _swollen(p: Packing, windings: bool) -> float:
    """E/ε."""
    equation = force_equation(net(p), winding=windings)
    δt = p.stiffness * (equation.Q @ equation.network.sigma)
    f = equation.matrices.system.solve(np.concatenate([np.zeros(equation.M.shape[0]), δt]))
    return relative_error(p.forces + f, p.forces)


def growth(counts: Floats, means: Floats, errors: Floats) -> tuple[float, float, float]:
    """(b, its standard error, χ² per degree of freedom) of the fit a (1 + b/N).

    With slope s = a b, var b = b² (var s/s² + var a/a² - 2 cov(s, a)/(s a)), times χ² per degree
    of freedom where it exceeds 1.
    """
    (s, a), C = np.polyfit(1 / counts, means, 1, w=1 / errors, cov="unscaled")
    off = (means - a - s / counts) / errors
    reduced = float(off @ off) / (len(counts) - 2)
    # var (s/a), written without dividing by s, which may be 0.
    b = s / a
    variance = (C[0, 0] + b**2 * C[1, 1] - 2 * b * C[0, 1]) / a**2
    return b, float(np.sqrt(variance * max(1.0, reduced))), reduced


def measured(delta: float, grains: int, seeds: Sequence[int]) -> Floats:
    """(packings, quantities) of gppsz, noise on diameters."""
    packings = make([Scene(grains, delta)] * len(seeds), seeds)
    return np.array([_of(p, seed) for p, seed in zip(packings, seeds, strict=True)])


def _of(p: Packing, seed: int) -> Floats:
    """K exactly up to 1000 grains, beyond by 24 probes, the same for both G."""
    n = net(p)
    if n.grains <= 1000:
        K = np.array([gain(n, winding=windings) for windings in (False, True)])
    else:
        z = np.random.default_rng([SEED, seed]).choice([-1.0, 1.0], (n.grains, 24))
        K = np.array([_probed(n, z, windings) for windings in (False, True)])
    ℓ, per_force = n.faces / n.contacts, p.pressure / mean_force(p.forces)
    loops = (n.faces + 2) / n.contacts
    return np.array([*K**2 / ℓ, K[1] ** 2 / loops, *K * per_force])


def _probed(network: ContactNetwork, z: Floats, windings: bool) -> float:
    equation = force_equation(network, winding=windings)
    δt = equation.Q @ (size_response(network, "diameter") @ z)
    b = np.concatenate([np.zeros((equation.M.shape[0], z.shape[1])), δt])
    f = equation.matrices.system.solve(b)
    return float(np.sqrt(np.sum(f**2) / f.size))
