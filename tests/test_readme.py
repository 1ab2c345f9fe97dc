"""What the README promises: its commands exist, its code runs, its numbers are the figures'."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dem import Scene, Settings
from studies.estimators import estimator_errors
from studies.experiment import experiment_errors
from studies.packings import packing_table
from studies.prefactors import prefactor_laws
from studies.tables import read_facts, read_table
from tests.readme_lines import lines

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()
ESTIMATORS = (ROOT / "docs" / "estimators.md").read_text()


def test_ten_lines_run_and_the_prediction_holds(capsys):
    code = lines()
    statements = [
        line for line in code.splitlines() if line and not line.startswith(("import", "from"))
    ]
    assert len(statements) <= 10
    exec(compile(code, "README.md", "exec"), {})
    exact, noisy, predicted = (
        float(line.split()[-1]) for line in capsys.readouterr().out.splitlines()
    )
    assert exact < 1e-7
    assert noisy == pytest.approx(predicted, rel=0.5)


def test_commands_exist():
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    named = set(re.findall(r"(?:`|^    )make ([\w-]+)", README, re.MULTILINE))
    assert named <= targets
    assert {"test-lowest", "nightly", "mutation"} <= named
    (block,) = re.findall(r"## Two commands\n.*?\n\n((?:    make [^\n]*\n)+)", README, re.DOTALL)
    assert len(block.splitlines()) == 2
    assert "make test" in (ROOT / ".ci" / "run").read_text()


def test_table_is_the_one_of_the_full_figures():
    """Every line that ``packing_table.text`` prints stands in the README, to the letter."""
    path = ROOT / "figures" / "table1.csv"
    flowing = " ".join(README.split())
    for line in packing_table.text(read_table(path), read_facts(path)["fits"]).splitlines():
        assert " ".join(line.split()) in flowing, line


@pytest.mark.parametrize(
    ("figure", "study"),
    [("fig4", estimator_errors), ("fig5", prefactor_laws), ("fig7", experiment_errors)],
)
def test_tables_of_the_estimators_are_those_of_the_full_figures(figure, study):
    """Every line that their studies print stands in docs/estimators.md, to the letter."""
    table = read_table(ROOT / "figures" / f"{figure}.csv")
    for line in study.text(table).splitlines():
        assert line in ESTIMATORS, line


def test_settings_and_scenes_of_the_docs_are_legal():
    """Every `Settings(...)` and `Scene(...)` the docs name can be made as it stands."""
    docs = "".join(p.read_text() for p in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
    named = set(re.findall(r"\b(?:Settings|Scene)(?:\.\w+)?\([^()]*\)", docs))
    assert len(named) >= 6
    for expression in named:
        eval(expression, {"Settings": Settings, "Scene": Scene})
