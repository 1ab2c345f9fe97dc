"""The Comment's sandpile in real units: grains of 0.5 mm, at depths up to 20 cm.

A slab of a monolayer of spheres, 50 wide and 20 high, lies between walls. The top wall bears the
sand above it, and gravity acts on the slab, too. Per length along x and per thickness d,

    p = φ ρ g h ,   κ = E_Y/(3 (1 - ν²)) ,   Δ = (p/κ)^(2/3) ,

with ρ the density of the grains, φ the share of the volume that they fill, h the depth of the top
of the slab, E_Y and ν of the grains. In units of κ and d a sphere weighs (π/6) ρ g d/κ, and a disk
of the scene π g'/4, so that g' = (2/3) ρ g d/κ. With sizes known to s (standard deviation of a
diameter) E = C s/(d Δ), where Δ is that of the slab's measured pressure.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from math import nan
from typing import Any

import numpy as np

from dem import Packing, Scene
from dem.model.confinement import Strip
from packing.contact_law.material import MATERIALS, Material
from scaling import (
    ContactNetwork,
    amplification,
    flat_guess,
    perturb,
    reconstruct,
    relative_error,
    stress,
)
from scaling.algebra.evidence import NotAccurate
from studies.error_bars import bar
from studies.packing_store import FULL, SEED, Edition, make

GRAINS = ("glass", "sand")
DIAMETER, GRAVITY, FILLED = 0.5e-3, 9.81, 0.6
DEPTHS = (0.025, 0.05, 0.10, 0.20)
"""Of the top of the slab, m."""
SIZES = (1e-6, 1e-7, 1e-8, 1e-9)
"""Sizes are known to this, m."""
MEASURED = {"10nm": 1e-8, "1nm": 1e-9}
"""Where E is below that of a flat guess, and Newton's method has answers."""
DRAWS = 4
TABLE = np.dtype([
    ("material", "U6"), ("depth", float), ("seed", int), ("told_delta", float), ("delta", float),
    ("residual", float), ("Z", float), ("exact", float), ("C", float),
    *((f"E_{name}", float) for name in MEASURED),
    *((f"answers_{name}", int) for name in MEASURED),
    ("flat_guess", float),
])  # fmt: skip
"""`told_delta` is that of the sand above, `delta` that of the slab's measured pressure; E of the
`answers` out of DRAWS draws of Newton's method, the rest being refused."""


def scene(material: Material, depth: float, wide: int, high: int) -> Scene:
    """The slab whose top lies at this depth."""
    pressure = FILLED * material.density * GRAVITY * depth / material.stiffness
    weight = 2 / 3 * material.density * GRAVITY * DIAMETER / material.stiffness
    return Scene(
        wide * high, pressure ** (2 / 3), aspect=wide / high, contact="hertz", boundary=Strip(),
        gravity=weight,
    )  # fmt: skip


def compute(edition: Edition, pool: Executor) -> np.ndarray:
    """One row per material, depth and packing."""
    (wide, high), packings = ((50, 20), 3) if edition.name == FULL.name else ((15, 6), 2)
    tasks = [(m, h, k) for m in GRAINS for h in DEPTHS for k in range(packings)]
    scenes = [scene(MATERIALS[m], h, wide, high) for m, h, _ in tasks]
    some = make(scenes, [k for *_, k in tasks], edition.backend, pool)
    return np.array(list(pool.map(row, some, tasks)), TABLE)


def row(p: Packing, case: tuple[str, float, int]) -> tuple[Any, ...]:
    """What is measured on one packing."""
    material, depth, seed = case
    n, law = ContactNetwork.from_packing(p), p.law
    pressure = float(np.trace(stress(n, p.forces))) / 2
    C = float(amplification(n, forces=p.forces, pressure=pressure, stiffness=law))
    rng = np.random.default_rng([SEED, GRAINS.index(material), DEPTHS.index(depth), seed])
    found = [measured(p, n, size / DIAMETER, rng) for size in MEASURED.values()]
    guess = relative_error(flat_guess(n, pressure), p.forces)
    errors, answers = zip(*found, strict=True)
    told = law.delta(p.pressure)
    exact = relative_error(reconstruct(n, law), p)
    about = material, depth, seed, told, law.delta(pressure), float(p.residuals().max())
    return (*about, p.coordination, exact, C, *errors, *answers, guess)


def measured(
    p: Packing, network: ContactNetwork, xi: float, rng: np.random.Generator
) -> tuple[float, int]:
    """E over the draws that have an answer, and how many have one."""
    squares = []
    for _ in range(DRAWS):
        try:
            found = reconstruct(perturb(network, xi, rng), p.law)
        except (RuntimeError, NotAccurate):
            continue
        squares.append(relative_error(found, p) ** 2)
    return (float(np.sqrt(np.mean(squares))) if squares else nan), len(squares)


def facts(edition: Edition) -> dict[str, Any]:
    """What the table does not say."""
    return {
        "edition_of_slab": edition.name, "noise_seed": SEED, "diameter": DIAMETER,
        "filled": FILLED, "draws": DRAWS, "gravity": GRAVITY,
        "modulus": {k: MATERIALS[k].modulus for k in GRAINS},
        "poisson": {k: MATERIALS[k].poisson for k in GRAINS},
        "density": {k: MATERIALS[k].density for k in GRAINS},
    }  # fmt: skip


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per material and depth: mean ± standard error over packings."""
    yield (
        "| grains | depth, cm | Δ of the sand above | Δ measured | residual, p | C "
        "| E predicted, sizes to 1 µm | 0.1 µm | 10 nm | 1 nm "
        "| measured, 10 nm | answers | 1 nm | answers | flat guess |"
    )
    yield "|" + "---|" * 15
    for material, depth in dict.fromkeys((str(r["material"]), float(r["depth"])) for r in table):
        r = table[(table["material"] == material) & (table["depth"] == depth)]
        predicted = [bar(predict(r, size)) for size in SIZES]
        last = [
            cell
            for name in MEASURED
            for cell in (
                bar(r[f"E_{name}"]) or "-",
                f"{r[f'answers_{name}'].sum()}/{DRAWS * len(r)}",
            )
        ]
        cells = [
            material, f"{100 * depth:g}", f"{r['told_delta'].mean():.2e}",
            f"{r['delta'].mean():.2e}", f"<= {r['residual'].max():.0e}", bar(r["C"]),
            *predicted, *last, bar(r["flat_guess"]),
        ]  # fmt: skip
        yield "| " + " | ".join(cells) + " |"


def predict(rows: np.ndarray, size: float) -> np.ndarray:
    """C s/(d Δ) of each packing."""
    return rows["C"] * size / (DIAMETER * rows["delta"])


def text(table: np.ndarray) -> str:
    """All lines."""
    return "\n".join(lines(table))
