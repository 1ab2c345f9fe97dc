"""The benchmarks on their smallest size: they run, and what they say of physics holds."""

from __future__ import annotations

import re
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from runpy import run_module

import numpy as np
import pytest

from benchmarks import __main__ as bench
from benchmarks import relaxation, size, solvers
from benchmarks.other_codes import lammps_wall_step, lammps_walls
from dem import refine, relax
from paper_figs import __main__ as figures
from scaling import force_equation, reconstruct, relative_error, tiled, tiled_forces
from studies.packing_store import FULL, QUICK, ROOT
from studies.registry import STUDIES
from studies.run import Run
from tests.conftest import packing
from tests.scaling.packings import network_of
from tests.test_layers import tops


def test_tiles_are_the_same_packing_many_times():
    """n × n copies: n² times the contacts and faces, the same forces, C and condition O(1)."""
    p = refine(packing(grains=48, delta=1e-3))
    one = network_of(p)
    network, forces = tiled(one, 3), tiled_forces(one, p.forces, 3)
    assert network.contacts == 9 * len(p.pairs)
    assert network.faces == network.contacts - len(network.active)
    assert relative_error(reconstruct(network, p.stiffness).forces, forces) < 1e-11


def test_every_solver_finds_the_forces(monkeypatch):
    """To rounding times the condition (squared where GᵀG is formed and not refined), or to 100
    times the tolerance it was given."""
    monkeypatch.setattr(solvers, "PATIENCE", 0.0)
    p = refine(packing(grains=48, delta=1e-3))
    condition = force_equation(tiled(network_of(p), 1)).conditioning.condition
    for name in solvers.SOLVERS:
        *_, error = solvers.measure((name, 0, p, 1))
        allowed = 1e-15 * condition**2
        if name.startswith("lsmr"):
            allowed = 100 * float(name.split()[1])
        assert error <= allowed, name


def test_steps_grow_as_the_inverse_root_of_the_deformation(monkeypatch):
    """Exponent 1/2 within 0.2: Δ = 1e-2, 1e-3, 1e-4, three small packings each."""
    monkeypatch.setattr(relaxation, "ways", lambda: {"default": relax})
    with ThreadPoolExecutor(1) as pool:
        table = relaxation.compute(pool, 36, 3, 4)
    for how in dict.fromkeys(table["how"]):
        slope, _ = relaxation.exponent(table, how)
        assert slope == pytest.approx(0.5, abs=0.2)
    assert "steps ~ Δ^-" in relaxation.text(table)


def test_memory_of_arrays_does_not_depend_on_size():
    """Bytes a grain of assembly, one tile against nine, within a quarter."""
    p = packing(grains=100, delta=1e-3)
    few, many = (size.assembly_memory((p, n))[-1] for n in (1, 3))
    assert many == pytest.approx(few, rel=0.25)


def test_exponents_come_with_their_errors():
    """seconds ~ N^1.5, off by ± 1 % in a pattern that tilts no line: slope exact, and its bar that
    of least squares, √(Σ residue²/2 / Σ (log N - mean)²)."""
    grains = np.array([100, 400, 1600, 6400])
    table = np.zeros(4, solvers.TABLE)
    table["solver"], table["grains"] = "factor", grains
    table["seconds"] = grains**1.5 * np.exp(0.01 * np.array([1, -1, -1, 1]))
    slope, error, sizes = solvers.exponents(table, "seconds")["factor"]
    assert sizes == 4
    assert slope == pytest.approx(1.5, abs=1e-9)
    assert error == pytest.approx(0.01 * np.sqrt(2 / 5) / np.log(4), rel=1e-6)
    assert not solvers.exponents(table, "MB")


@pytest.mark.parametrize("name", ["benchmarks", "paper_figs", "studies"])
def test_makefile_runs_them_as_modules(name):
    """As scripts they would not find each other, for they are not installed."""
    assert f"$(RUN) -m {name} " in (ROOT / "Makefile").read_text()


PROGRAMS = [
    "benchmarks",
    "benchmarks.other_codes.c_step",
    "benchmarks.relaxation",
    "benchmarks.step_cost",
    "benchmarks.other_codes.lammps_hertz",
    "benchmarks.other_codes.lammps_packing",
    "benchmarks.other_codes.lammps_step",
    "benchmarks.other_codes.lammps_wall_step",
    "benchmarks.other_codes.lammps_walls",
    "paper_figs",
    "studies",
]


def test_every_program_is_listed():
    """Whatever can be run with ``python -m`` stands above."""
    found = set()
    for folder in ("benchmarks", "paper_figs", "studies"):
        for module in (ROOT / folder).rglob("*.py"):
            if '\nif __name__ == "__main__":' in module.read_text():
                name = ".".join(module.relative_to(ROOT).with_suffix("").parts)
                found.add(name.removesuffix(".__main__"))
    assert found == set(PROGRAMS)


@pytest.fixture
def said(monkeypatch, capsys):
    """``python -m program words`` -> exit code, output and errors."""

    def run(program: str, *words: str) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", [program, *words])
        with pytest.raises(SystemExit) as end:
            run_module(program, run_name="__main__", alter_sys=True)
        return end.value.code, *capsys.readouterr()

    return run


@pytest.mark.filterwarnings("ignore:.*found in sys.modules:RuntimeWarning")
@pytest.mark.parametrize("program", PROGRAMS)
def test_help_is_given_at_once_and_other_words_are_refused(said, program):
    code, output, _ = said(program, "--help")
    assert code == 0
    assert output.startswith(f"usage: python -m {program} ")
    code, _, errors = said(program, "phrenology")
    assert code == 2
    assert f"python -m {program}: error: " in errors
    assert "phrenology" in errors
    assert "Traceback" not in errors


@pytest.mark.filterwarnings("ignore:.*found in sys.modules:RuntimeWarning")
@pytest.mark.parametrize(
    ("program", "option", "names"),
    [
        ("benchmarks", ["--only"], bench.PARTS),
        ("studies", [], STUDIES),
        ("paper_figs", ["--only"], figures.NAMES),
    ],
)
def test_unknown_names_are_refused_with_those_there_are(said, program, option, names):
    code, _, errors = said(program, *option, next(iter(names)), "phrenology")
    assert code == 2
    assert "phrenology: no such " in errors
    assert f"there are {', '.join(names)}" in errors
    shown = set(re.findall(r"\w+", said(program, "--help")[1]))
    assert set(names) <= shown


def test_quick_runs_leave_the_full_results_alone(monkeypatch, tmp_path, capsys):
    """A quick run writes below build/, a full one where the committed tables are."""
    monkeypatch.setattr("studies.run.QUICK", replace(QUICK, results=tmp_path / "quick"))
    monkeypatch.setattr("studies.run.FULL", replace(FULL, results=tmp_path / "full"))
    monkeypatch.setattr(bench.step_cost, "main", lambda: print("a table"))
    bench.main(["--only", "step_cost"])
    assert (tmp_path / "quick" / "step_cost.md").read_text() == "a table\n"
    assert not (tmp_path / "full").exists()
    bench.main(["--full", "--only", "step_cost"])
    assert (tmp_path / "full" / "step_cost.md").exists()
    assert capsys.readouterr().out.count("a table") == 2


@pytest.mark.parametrize("folder", ["benchmarks", "studies"])
def test_what_computes_writes_through_its_run_and_draws_nothing(folder):
    """No other path to the committed results, and no plotting; studies know no benchmark."""
    above = {"paper_figs", "matplotlib"} | ({"benchmarks"} if folder == "studies" else set())
    for module in (ROOT / folder).rglob("*.py"):
        assert not tops(module) & above, module.name
        assert '"results"' not in module.read_text() or module.name == "packing_store.py"


def test_a_run_says_its_table_line_by_line(tmp_path, capsys):
    """And keeps it whole."""
    run = Run(replace(QUICK, results=tmp_path))
    run.keep("table", iter(["| a |", "|---|"]))
    assert (tmp_path / "table.md").read_text() == "| a |\n|---|\n"
    assert "| a |\n|---|\n" in capsys.readouterr().out


def test_lammps_comes_to_the_same_packing_between_walls():
    """Without friction to round-off, wall forces among them; a tenth more weight is noticed."""
    try:
        assert pytest.importorskip("lammps").lammps
    except OSError as missing:
        pytest.skip(f"LAMMPS cannot be loaded: {missing}")
    scene = replace(lammps_walls.scenes(20)["box, weight"], friction=0.0)
    at = lammps_walls.held(scene)
    mine = lammps_walls.here(at)
    assert sum(j >= 20 for _, j in mine) > 5
    normal, tangential, alone = lammps_walls.apart(mine, lammps_walls.there(at))
    assert (normal < 1e-9, tangential, alone) == (True, 0.0, 0)
    heavier = lammps_walls.apart(mine, lammps_walls.there(at, lammps_walls.HEAVIER))
    assert heavier[0] > 1e-2


def test_steps_between_walls_are_timed_with_and_without_them(monkeypatch):
    """The scenes bear what they are said to, and the still one does not move. No times."""
    monkeypatch.setattr(lammps_wall_step, "STEPS", 3)
    at = lammps_walls.held(lammps_walls.scenes(20)["box, weight, Hertz"])
    for kind in ("all", "still", "bare", "linear"):
        assert lammps_wall_step.ours(at, "numpy", kind)() > 0
    rows = [{"scene": "walls", "code": "numpy", "contacts": 5, "feet": 2,
             "us": np.ones(3), "LAMMPS": np.ones(3), "outside": 2 * np.ones(3)}]  # fmt: skip
    assert "| walls | numpy | 5 | 2 | 1.0 | 1.00 | 2.00 |  |" in lammps_wall_step.text(rows)
