"""One collapse for all worlds: E against ξ/Δ* in a periodic cell, between walls, under weight.

    E = C ξ/Δ* ,   Δ* = law.delta(p*) ,   p* = tr σ/2

p* is the measured pressure of the whole packing: between walls it is not only what presses the
top wall, for weight adds to it and side walls bear some. E is the error of `gppsz`, by Newton's
method for elastic spheres, with noise ξ on the diameters; loads and the lines of the walls are
exact. C is the prefactor from the error map at the slopes of the law.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from math import pi, sqrt
from typing import Any

import numpy as np

from dem import Packing, Scene
from dem.model.confinement import Box, Strip
from packing.contact_law import law_of
from scaling import ContactNetwork, amplification, perturb, reconstruct, relative_error, stress
from scaling.algebra.evidence import NotAccurate
from studies.error_bars import bar
from studies.packing_store import FULL, SEED, Edition, make

HEAVY = "weight", "box with weight"
WORLDS: dict[str, dict[str, Any]] = {
    "periodic": {},
    "smooth walls": {"boundary": Strip("smooth")},
    "frictional walls": {"boundary": Strip()},
    "rough walls": {"boundary": Strip("rough")},
    "box": {"boundary": Box()},
    "box pressed twice": {"boundary": Box(pressed=2)},
    "weight": {"boundary": Strip()},
    "box with weight": {"boundary": Box()},
}
CONTACTS = "linear", "hertz"
FRICTIONS = (0.03, 0.3, 3.0)
"""Two decades, between rough walls."""
DELTAS = (1e-2, 1e-4)
"""Told the scene."""
OVERLOAD = 4.0
"""Weight of a column of grains as high as it is wide, over the load on the top wall."""
RANGES = {"small": (-3, -7 / 3), "middle": (-7 / 3, -5 / 3), "large": (-5 / 3, -1)}
"""Powers of ten between which ξ/Δ* of a packing lies."""
DRAWS = 4
METHODS = ("gppsz", "balanced", "direct")
"""Read as linear."""
TABLE = np.dtype([
    ("world", "U20"), ("contact", "U6"), ("friction", float), ("told_delta", float),
    ("seed", int), ("grains", int), ("Z", float), ("residual", float), ("delta", float),
    ("wrong_delta", float), ("C", float), ("exact", float),
    *((f"{what}_{name}", float) for name in RANGES for what in ("ratio", "E")),
    ("refused", int), *((f"linear_{m}", float) for m in METHODS),
])  # fmt: skip
"""Δ* is `delta`; `wrong_delta` that of the other law; E without noise `exact`; `refused` draws of
the noise gave no answer; `linear_...` is E with the law taken for linear, see `as_linear`."""


def size_of(edition: Edition) -> tuple[int, int]:
    """Grains, and packings of each scene."""
    return (300, 8) if edition.name == FULL.name else (50, 2)


def scene(world: str, contact: str, friction: float, delta: float, grains: int) -> Scene:
    """The scene of a world, with weight where it is named."""
    more = dict(WORLDS[world])
    plain = Scene(grains, delta, friction=friction, contact=contact)
    if world in HEAVY:
        more["gravity"] = OVERLOAD * plain.pressure / sqrt(grains * pi / 4 * 0.8)
    return Scene(grains, delta, friction=friction, contact=contact, **more)


def cases() -> list[tuple[str, str, float]]:
    """World, contact, friction: every world at 0.3, and rough walls at all of them."""
    found = [(w, k, 0.3) for w in WORLDS for k in CONTACTS]
    return found + [("rough walls", k, μ) for k in CONTACTS for μ in FRICTIONS if μ != 0.3]


def compute(edition: Edition, pool: Executor) -> np.ndarray:
    """One row per world, contact, friction, Δ and packing."""
    grains, packings = size_of(edition)
    tasks = [(*case, d, k) for case in cases() for d in DELTAS for k in range(packings)]
    scenes = [scene(world, contact, μ, d, grains) for world, contact, μ, d, _ in tasks]
    some = make(scenes, [k for *_, k in tasks], edition.backend, pool)
    return np.array(list(pool.map(row, some, tasks)), TABLE)


def row(p: Packing, case: tuple[str, str, float, float, int]) -> tuple[Any, ...]:
    """What is measured on one packing."""
    world, contact, friction, told, seed = case
    n, law = ContactNetwork.from_packing(p), p.law
    pressure = float(np.trace(stress(n, p.forces))) / 2
    delta = law.delta(pressure)
    other = law_of(1.0).delta(pressure) if contact == "hertz" else pressure ** (2 / 3)
    exact = relative_error(reconstruct(n, law), p)
    C = amplification(n, forces=p.forces, pressure=pressure, stiffness=law)
    rng, errors, refused = np.random.default_rng(noise_seed(case)), [], 0
    for low, high in RANGES.values():
        ratio, squares = 10 ** rng.uniform(low, high), []
        for _ in range(DRAWS):
            try:
                noisy = perturb(n, ratio * delta, rng)
                squares.append(relative_error(reconstruct(noisy, law), p) ** 2)
            except (RuntimeError, NotAccurate):
                refused += 1
        errors += [ratio, np.sqrt(np.mean(squares)) if squares else np.nan]
    linear = [as_linear(n, p, pressure, m) for m in METHODS]
    residual = float(p.residuals().max())
    about = world, contact, friction, told, seed, len(p.radii), p.coordination, residual
    return (*about, delta, other, float(C), exact, *errors, refused, *linear)


def noise_seed(case: tuple[str, str, float, float, int]) -> list[int]:
    """Every packing has noise of its own."""
    world, contact, friction, told, seed = case
    which = [*WORLDS].index(world), CONTACTS.index(contact), round(1e3 * friction)
    return [SEED, seed, *which, DELTAS.index(told)]


def as_linear(network: ContactNetwork, p: Packing, pressure: float, method: str) -> float:
    """E with f_n = κ δ instead of the law, and the κ that is best in hindsight: none does better.

    Forces are linear in κ at given loads, so two solutions hold them for every κ.
    """
    soft = pressure / p.law.delta(pressure)
    one, two = (reconstruct(network, k * soft, method).forces for k in (1.0, 2.0))
    more, lacking = two - one, p.forces - one
    return relative_error(one + (more @ lacking) / (more @ more) * more, p.forces)


def facts(edition: Edition) -> dict[str, Any]:
    """What the table does not say."""
    return {"noise_seed": SEED, "draws": DRAWS, "ranges": RANGES, "overload": OVERLOAD}


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per world, contact, friction and Δ: mean ± standard error over packings."""
    yield (
        "| world | contact | μ | Δ* | Z | C | E Δ*/ξ, measured, over C "
        f"| read as linear: {' | '.join(METHODS)} |"
    )
    yield "|" + "---|" * (7 + len(METHODS))
    keys = dict.fromkeys(
        (str(r["world"]), str(r["contact"]), float(r["friction"]), float(r["told_delta"]))
        for r in table
    )
    for world, contact, friction, told in keys:
        mine = (table["world"] == world) & (table["contact"] == contact)
        r = table[mine & (table["friction"] == friction) & (table["told_delta"] == told)]
        linear = [bar(r[f"linear_{m}"]) if contact == "hertz" else "-" for m in METHODS]
        cells = [
            world, contact, f"{friction:g}", f"{r['delta'].mean():.2g}", bar(r["Z"]), bar(r["C"]),
            bar(np.mean([over_prefactor(r, name) for name in RANGES], axis=0)), *linear,
        ]  # fmt: skip
        yield "| " + " | ".join(cells) + " |"
    refused, all_draws = table["refused"].sum(), len(table) * len(RANGES) * DRAWS
    yield (
        f"\n{len(r)} packings each; residuals <= {table['residual'].max():.0e} p, E without noise "
        f"<= {table['exact'].max():.0e}; {refused} of {all_draws} draws of the noise refused"
    )


def over_prefactor(rows: np.ndarray, name: str) -> np.ndarray:
    """E Δ*/ξ over C, at the strengths of the noise within one of RANGES."""
    return rows[f"E_{name}"] / rows[f"ratio_{name}"] / rows["C"]


def text(table: np.ndarray) -> str:
    """All lines."""
    return "\n".join(lines(table))
