"""The studies behind the paper's figures, and the tables that they write: one each."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from studies.estimators import estimator_errors
from studies.experiment import experiment_errors
from studies.one_packing import error_maps, force_chains, grains
from studies.packings import packing_table
from studies.prefactors import collapse, loop_sums, prefactor_laws, world_layers, worlds
from studies.run import Run

Study = Callable[[Run], None]

OF_FIGURES: dict[str, tuple[str, ModuleType]] = {
    "collapse": ("fig1", collapse), "loop_sums": ("fig2", loop_sums),
    "force_chains": ("fig3", force_chains), "estimator_errors": ("fig4", estimator_errors),
    "prefactor_laws": ("fig5", prefactor_laws), "error_maps": ("fig6", error_maps),
    "experiment_errors": ("fig7", experiment_errors), "grains": ("grains", grains),
    "packing_table": ("table1", packing_table),
    "worlds": ("fig8", worlds), "world_layers": ("fig8_layers", world_layers),
}  # fmt: skip
"""The table of each, and its module."""
CAPTIONS = {
    "estimator_errors": "Fig. 4: E against noise, ± standard deviation over packings",
    "prefactor_laws": "Fig. 5: C = E/(ξ/Δ), noise on diameters, on positions",
    "experiment_errors": "Fig. 7: contacts read off noisy positions, and what E they leave",
    "worlds": "Fig. 8: C and E of each world, noise on diameters",
    "world_layers": "Fig. 8: layers under weight",
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


def _of_scenes(study: str) -> Study:
    """One that makes its own packings, of scenes that are not those of the other figures."""
    name, module = OF_FIGURES[study]

    def part(run: Run) -> None:
        with run.pool() as pool:
            table = module.compute(run.edition, pool)
        run.write_of_figure(name, table, module.facts(run.edition))
        run.report(f"{CAPTIONS[study]}\n\n{module.text(table)}\n")

    return part


def _table_1(run: Run) -> None:
    """It takes its prefactors over from Fig. 1."""
    rows = packing_table.compute(run.packings, run.errors)
    fits = packing_table.fits(run.packings, run.errors)
    about = packing_table.facts(run.packings, run.edition)
    run.write_of_figure("table1", rows, about | {"fits": fits})
    run.report(f"Table 1\n\n{packing_table.text(rows, fits)}\n")


STUDIES: dict[str, Study] = {
    **{name: _of_figure(name) for name in OF_FIGURES},
    "packing_table": _table_1,
    **{name: _of_scenes(name) for name in ("worlds", "world_layers")},
}
