"""Every study by name: what it computes, and the table it writes.

    figures     one table each, in figures/ (quick: build/figures/)
    estimators  what docs/estimators.md quotes
    packings    what docs/trade.md quotes

Others write to results/ (quick: build/results/): numbers as CSV, words as Markdown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType

from dem import Packing, Scene
from studies import million_grains
from studies.estimators import (
    bound,
    coverage,
    estimator_errors,
    ladder,
    prior,
    ridge,
    sensitivity,
    stress,
)
from studies.experiment import experiment_errors, floor, rounding, stiffness
from studies.one_packing import error_maps, force_chains, grains
from studies.packing_store import DELTAS, SEED, make
from studies.packings import (
    anisotropy,
    continuation,
    dem_trade,
    packing_table,
    ramps,
    same_packing,
)
from studies.prefactors import (
    collapse,
    finite_size,
    laws,
    loop_sums,
    measures,
    prefactor,
    prefactor_laws,
)
from studies.run import Run

Study = Callable[[Run], None]

OF_FIGURES: dict[str, tuple[str, ModuleType]] = {
    "collapse": ("fig1", collapse), "loop_sums": ("fig2", loop_sums),
    "force_chains": ("fig3", force_chains), "estimator_errors": ("fig4", estimator_errors),
    "prefactor_laws": ("fig5", prefactor_laws), "error_maps": ("fig6", error_maps),
    "experiment_errors": ("fig7", experiment_errors), "grains": ("grains", grains),
    "packing_table": ("table1", packing_table),
}  # fmt: skip
"""The table of each, and its module."""
CAPTIONS = {
    "estimator_errors": "Fig. 4: E against noise, ± standard deviation over packings",
    "prefactor_laws": "Fig. 5: C = E/(ξ/Δ), noise on diameters, on positions",
    "experiment_errors": "Fig. 7: contacts read off noisy positions, and what E they leave",
}


def _of_figure(study: str) -> Study:
    """The table, and in words what the docs quote of it."""
    name, module = OF_FIGURES[study]

    def part(run: Run) -> None:
        table = module.compute(run.packings, run.edition)
        run.write_of_figure(name, table, module.facts(run.packings, run.edition))
        if study in CAPTIONS:
            run.report(f"{CAPTIONS[study]}\n\n{module.text(table)}\n")

    return part


def _table_1(run: Run) -> None:
    """It takes its prefactors over from Fig. 1."""
    rows = packing_table.compute(run.packings, run.errors)
    fits = packing_table.fits(run.packings, run.errors)
    about = packing_table.facts(run.packings, run.edition)
    run.write_of_figure("table1", rows, about | {"fits": fits})
    run.report(f"Table 1\n\n{packing_table.text(rows, fits)}\n")


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
    **{name: _of_figure(name) for name in OF_FIGURES if name != "packing_table"},
    "packing_table": _table_1,
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
    "million_grains": _million,
    "dem_trade": _settings, "same_packing": _resting, "ramps": _pressures, "ramp_rates": _paces,
    "continuation": _continued, "rounding": _rounded, "floor": _no_noise,
}  # fmt: skip
