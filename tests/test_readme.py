"""What the README promises: its commands exist, its code runs, its numbers are the figures'."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()


def test_ten_lines_run_and_the_prediction_holds(capsys):
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL).group(1)
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
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"(?:`|^    )make (\w+)", README, re.MULTILINE)) <= targets
    assert "make test" in (ROOT / ".ci" / "run").read_text()


def test_table_is_the_one_of_the_full_figures():
    lines = (ROOT / "figures" / "table1.csv").read_text().splitlines()[1:]
    for row in csv.DictReader(lines):
        shown = re.search(
            rf"^\| {float(row['delta']):.0e} ".replace("e-0", "e-") + r".*$", README, re.M
        )
        assert shown, row["delta"]
        for name in ("C_diameter", "C_radius"):
            assert f"{float(row[name]):.3f} ±" in shown.group(), (row["delta"], name)
        assert f"{float(row['Z']):.2f} ±" in shown.group()
