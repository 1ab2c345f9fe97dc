"""Every study by name: what it computes, and the table it writes.

    figures     one table each, in figures/ (quick: build/figures/)
    estimators  what docs/estimators.md quotes
    packings    what docs/trade.md quotes

Others write to results/ (quick: build/results/): numbers as CSV, words as Markdown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType

import numpy as np

from dem import Packing, Scene
from studies import million_grains, of_figures
from studies.estimators import bound, coverage, ladder, prior, ridge, sensitivity, stress
from studies.experiment import floor, foreign, photoelastic, rounding, sandpile, stiffness
from studies.of_figures import Study
from studies.packing_store import DELTAS, SEED, make
from studies.packings import (
    anisotropy,
    between_walls,
    continuation,
    dem_trade,
    hertz,
    late_drag,
    ramps,
    same_packing,
    same_statistics,
    silo,
)
from studies.prefactors import finite_size, laws, measures, prefactor
from studies.run import Run
from studies.third_party import folder


def _lines(name: str, lines: Callable[[], Iterator[str]]) -> Study:
    """One that says its table line by line; it has one edition."""
    return lambda run: run.keep(name, lines())


def _sampled(name: str, module: ModuleType, **facts: object) -> Study:
    """One row per packing and case, and its means in words."""

    def part(run: Run) -> None:
        grains, packings = (300, module.COUNT) if run.full else (100, 4)
        table = module.compute(grains, packings)
        run.keep(name, module.text(table))
        run.write(name, table, grains=grains, packings=packings, **facts)

    return part


def _of_others(name: str, lines: Callable[[], Iterator[str]]) -> Study:
    """One of packings of other groups; skipped by name where they are not at hand."""

    def part(run: Run) -> None:
        if folder() is None:
            run.report(f"{name}: skipped, PACKING_DATA names no folder with packings of others")
        else:
            run.keep(name, lines())

    return part


def _million(run: Run) -> None:
    run.keep("million_grains", million_grains.lines(32 if run.full else 4))


def _settings(run: Run) -> None:
    deltas = (1e-2, 1e-4, 1e-6) if run.full else (1e-2, 1e-4)
    with run.pool() as pool:
        table = dem_trade.compute(
            pool, 300 if run.full else 100, deltas, range(1, 9 if run.full else 5)
        )
    run.keep("dem_trade", dem_trade.text(table))
    run.write("dem_trade", table)


def _resting(run: Run) -> None:
    deltas = (1e-2, 1e-3, 1e-4) if run.full else (1e-2, 1e-3)
    with run.pool() as pool:
        table = same_packing.compute(pool, 300, deltas, range(1, 17 if run.full else 5))
    run.keep("same_packing", same_packing.text(table))


def _ensembles(run: Run) -> None:
    with run.pool() as pool:
        tables = [
            same_statistics.compute(pool, (grains,), (1e-2, 1e-4), range(1, 1 + seeds))
            for grains, seeds in (((1000, 16), (10_000, 4)) if run.full else ((300, 4),))
        ]
    table = np.concatenate(tables)
    run.keep("same_statistics", same_statistics.text(table))
    run.write("same_statistics", table)


def _late(run: Run) -> None:
    grains, seeds = (10_000, 4) if run.full else (300, 3)
    with run.pool() as pool:
        table = late_drag.compute(pool, grains, (1e-2, 1e-4), range(1, 1 + seeds))
    run.keep("late_drag", late_drag.text(table))
    run.write("late_drag", table)


def _spheres(run: Run) -> None:
    grains, packings, deltas = (300, 8, 6) if run.full else (100, 3, 4)
    table = hertz.compute(grains, packings, hertz.DELTAS[:deltas])
    run.keep("hertz", hertz.text(table))
    run.write("hertz", table, grains=grains, noise_seed=SEED)


def _sand(run: Run) -> None:
    with run.pool() as pool:
        table = sandpile.compute(run.edition, pool)
    run.keep("sandpile", sandpile.text(table))
    run.write("sandpile", table, **sandpile.facts(run.edition))


def _walls(run: Run) -> None:
    grains, packings = (300, 8) if run.full else (60, 2)
    table = between_walls.compute(grains, packings)
    run.keep("between_walls", between_walls.text(table))
    run.write("between_walls", table, grains=grains, packings=packings)


def _silo(run: Run) -> None:
    grains, packings = (400, 16) if run.full else (200, 4)
    table = silo.compute(grains, packings)
    run.keep("silo", silo.text(table))
    run.write("silo", table, packings=packings, **silo.facts())


def _pressures(run: Run) -> None:
    with run.pool() as pool:
        table = ramps.compute(pool, 1000 if run.full else 300, range(1, 9))
    run.keep("ramps", ramps.text(table))
    run.write("ramps", table)


def _paces(run: Run) -> None:
    with run.pool() as pool:
        found = ramps.rates(pool, 64, range(1, 17 if run.full else 5))
    run.keep("ramp_rates", ramps.text_of_rates(found))


def _continued(run: Run) -> None:
    with run.pool() as pool:
        found = continuation.compute(pool, 200, range(1, 9 if run.full else 4))
    run.keep("continuation", continuation.text(found))


def _pairs_of(deltas: tuple[float, ...]) -> list[Packing]:
    return make([Scene(150, d) for d in deltas for _ in (1, 2)], [1, 2] * len(deltas))


def _rounded(run: Run) -> None:
    table = rounding.compute(_pairs_of(DELTAS))
    run.keep("rounding", rounding.text(table))
    run.write("rounding", table)


def _no_noise(run: Run) -> None:
    table = floor.compute(_pairs_of(floor.DELTAS))
    run.keep("floor", floor.text(table))
    run.write("floor", table)


STUDIES: dict[str, Study] = {
    **of_figures.STUDIES,
    "laws": _lines("laws", laws.lines), "prefactor": _lines("prefactor", prefactor.lines),
    "measures": _lines("measures", measures.lines),
    "finite_size": _lines("finite_size", finite_size.lines),
    "positions": _lines("positions", bound.positions), "ratio": _lines("ratio", bound.ratio),
    "ladder": _sampled("ladder", ladder, ramp=[*ladder.UP, *ladder.DOWN]),
    "ridge": _sampled("ridge", ridge, noise_seed=SEED),
    "sensitivity": _sampled("sensitivity", sensitivity, noise_seed=SEED),
    "stress": _lines("stress", stress.lines), "anisotropy": _lines("anisotropy", anisotropy.lines),
    "prior": _sampled("prior", prior, noise_seed=SEED),
    "coverage": _lines("coverage", coverage.lines),
    "stiffness": _lines("stiffness", stiffness.lines),
    "foreign": _of_others("foreign", foreign.lines),
    "photoelastic": _of_others("photoelastic", photoelastic.lines),
    "million_grains": _million,
    "dem_trade": _settings, "same_packing": _resting, "same_statistics": _ensembles,
    "late_drag": _late,
    "hertz": _spheres, "between_walls": _walls, "sandpile": _sand, "silo": _silo,
    "ramps": _pressures, "ramp_rates": _paces,
    "continuation": _continued, "rounding": _rounded, "floor": _no_noise,
}  # fmt: skip
