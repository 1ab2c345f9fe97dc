"""Gains against loops per contact and hyperstaticity per unknown, over friction and N."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dem import Scene
from scaling import error_map, force_equation
from studies.open_regions import without_dangling
from studies.packing_store import DELTAS, SEED, cell_of, full, make, net
from studies.prefactors import prefactor_laws


def lines() -> Iterator[str]:
    """K² over loops per contact and so on, mean ± standard deviation over three packings."""
    groups = {f"N=1000 μ=0.3 Δ={d:g}": [full(d, k) for k in range(3)] for d in DELTAS}
    for d in (1e-2, 1e-4):
        for mu in (0.0, 0.1, 1.0):
            scene = Scene(300, d, friction=mu)
            groups[f"N=300 μ={mu:g} Δ={d:g}"] = make([scene] * 3, range(3))
        for n in (100, 300):
            groups[f"N={n} μ=0.3 Δ={d:g}"] = make([Scene(n, d)] * 3, range(3))
    yield (
        "| packings | Z | loops/c | h/unknowns | gppsz K²/(l/c) | balanced K²/h | bound K/h |"
        " gppsz/bound (positions) | balanced/bound |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    everything: list[np.ndarray] = []
    smooth: list[np.ndarray] = []
    for name, packings in groups.items():
        t = np.array([prefactor_laws.row(p) for p in packings], prefactor_laws.TABLE)
        (everything if t["friction"][0] else smooth).append(t)
        cells = [
            t["Z"], t["loops"], t["hyperstaticity"],
            t["K_gppsz_diameter"] ** 2 / t["loops"],
            t["K_balanced_diameter"] ** 2 / t["hyperstaticity"],
            t["K_optimal_position"] / t["hyperstaticity"],
            t["K_gppsz_position"] / np.maximum(t["K_optimal_position"], 1e-12),
            t["K_balanced_position"] / np.maximum(t["K_optimal_position"], 1e-12),
        ]  # fmt: skip
        text = " | ".join(
            "∞" if v.mean() > 1e6 else f"{v.mean():.3f} ± {v.std(ddof=1):.3f}" for v in cells
        )
        yield f"| {name} | {text} |"
    for name, (mean, sd) in prefactor_laws.laws(np.concatenate(everything)).items():
        yield f"all with friction: {name} = {mean:.3f} ± {sd:.3f}"
    for name, (mean, sd) in prefactor_laws.laws(np.concatenate(smooth)).items():
        yield f"all without: {name} = {mean:.3f} ± {sd:.3f}"
    yield from cut()


def cut() -> Iterator[str]:
    """A region with known boundary forces against the periodic packing it is cut from."""
    for d in (1e-2, 1e-4):
        p = full(d)
        f = p.forces.reshape(2, -1)
        cell = cell_of(p)
        mask = np.linalg.norm(p.positions - cell.sum(axis=0) / 2, axis=1) < cell[0, 0] / 2.2
        region = without_dangling(net(p), mask, f)
        equation = force_equation(region)
        K, bar = error_map(region).estimated_gain(np.random.default_rng(SEED), 12)
        ratio = K**2 / (region.faces / region.contacts)
        h = equation.hyperstaticity / equation.unknowns
        yield (
            f"open region Δ={d:g}, {len(region.active)} grains, Z={region.coordination:.3f}: "
            f"gppsz K²/(l/c) = {ratio:.3f} ± {2 * bar * ratio / K:.3f} (standard error of 12 "
            f"probes, one packing), h/unknowns = {h:.3f}, "
            f"balanced K = {error_map(region, 'balanced').gain:.3f}"
        )
