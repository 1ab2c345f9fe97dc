"""Columns of a CSV as a table of Markdown. A line each: its heading, and how a row is written.

Δ = {delta:.0e}
C = {C_diameter:.3f} ± {C_sd:.3f}
rows: friction = 0.3                      only those with this value
"""

from __future__ import annotations

import csv
from pathlib import Path


def table(path: Path, wanted: list[str]) -> list[str]:
    """Lines of Markdown: the columns ``wanted`` of the CSV at ``path``."""
    rows, columns = read(path), []
    for line in filter(str.strip, wanted):
        if line.startswith("rows:"):
            name, value = (part.strip() for part in line.removeprefix("rows:").split(" = "))
            rows = [row for row in rows if row[name] == number(value)]
        else:
            columns.append([part.strip() for part in line.rsplit(" = ", 1)])
    if not rows:
        raise ValueError("no row is left")
    lines = [[heading for heading, _ in columns], ["---"] * len(columns)]
    lines += [[form.format(**row) for _, form in columns] for row in rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def read(path: Path) -> list[dict[str, float | str]]:
    """The rows of a CSV, by the names in its first line; lines of comment are left out."""
    with path.open(encoding="utf-8", newline="") as stream:
        lines = [line for line in stream if not line.startswith("#")]
    return [{name: number(value) for name, value in row.items()} for row in csv.DictReader(lines)]


def number(text: str) -> float | str:
    """A number where it is one."""
    try:
        return float(text)
    except ValueError:
        return text
