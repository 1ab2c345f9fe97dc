"""What the README promises: its commands exist, its code runs, its numbers are the figures'."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from dem import Scene, Settings
from paper_figs import fig4, fig5, fig7, table1
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
    """Every line that ``table1.text`` prints stands in the README, to the letter."""
    first, _, *_ = (ROOT / "figures" / "table1.csv").read_text().splitlines()
    table = np.genfromtxt(
        ROOT / "figures" / "table1.csv", delimiter=",", names=True, skip_header=1
    )
    fits = json.loads(first.removeprefix("# "))["fits"]
    flowing = " ".join(README.split())
    for line in table1.text(table, fits).splitlines():
        assert " ".join(line.split()) in flowing, line


@pytest.mark.parametrize("figure", [fig4, fig5, fig7])
def test_tables_of_the_estimators_are_those_of_the_full_figures(figure):
    """Every line that figures 4, 5 and 7 print stands in docs/estimators.md, to the letter."""
    path = ROOT / "figures" / f"{figure.__name__.split('.')[-1]}.csv"
    table = np.genfromtxt(
        path, figure.TABLE, delimiter=",", names=True, skip_header=1, encoding="utf-8"
    )
    for line in figure.text(table).splitlines():
        assert line in ESTIMATORS, line


def test_settings_and_scenes_of_the_docs_are_legal():
    """Every `Settings(...)` and `Scene(...)` the docs name can be made as it stands."""
    docs = "".join(p.read_text() for p in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
    named = set(re.findall(r"\b(?:Settings|Scene)(?:\.\w+)?\([^()]*\)", docs))
    assert len(named) >= 6
    for expression in named:
        eval(expression, {"Settings": Settings, "Scene": Scene})
