"""Tables read as they are, by NumPy and by a plain reader of CSV, and say what they are."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from studies.packing_store import ROOT
from studies.tables import provenance, read_facts, read_table, write_table

COMMITTED = [p for folder in ("figures", "results") for p in sorted((ROOT / folder).glob("*.csv"))]


@pytest.mark.parametrize("path", COMMITTED, ids=lambda p: p.stem)
def test_committed_tables_are_read_as_they_are(path):
    """The names of the first line, none changed, all rows, numbers where numbers are."""
    table = np.genfromtxt(path, names=True, delimiter=",", dtype=None, encoding="utf-8")
    with path.open(newline="") as stream:
        names, *rows = csv.reader(stream)
    assert list(table.dtype.names) == names
    assert len(table) == len(rows) > 1
    words = {"how", "kind", "knob", "value", "history", "method", "noise", "outcome", "solver",
             "study", "told", "world", "law", "contact", "material"}  # fmt: skip
    for name in names:
        assert table.dtype[name].kind in "ifb" or name in words, name
    facts = read_facts(path)
    assert facts["versions"]["numpy"]
    assert "edition" in facts or "packings" in facts


def test_a_table_comes_back(tmp_path):
    """Numbers to nine digits, integers, truth and words; one row too. Control: a tenth digit is
    lost."""
    kinds = [("name", "U9"), ("x", float), ("k", int), ("held", bool)]
    table = np.array([("μ = 0.3", 1 / 3, 2, True), ("ξ", np.nan, -1, False)], kinds)
    path = tmp_path / "new" / "t.csv"
    for rows in (table, table[:1]):
        write_table(path, rows, provenance(seed=5))
        found = read_table(path)
        assert found.dtype.names == table.dtype.names
        assert found["name"].tolist() == rows["name"].tolist()
        np.testing.assert_allclose(found["x"], rows["x"], rtol=1e-9)
        assert found["x"][0] != 1 / 3
        assert found["k"].tolist() == rows["k"].tolist()
        assert found["held"].tolist() == rows["held"].tolist()
    assert read_facts(path)["seed"] == 5
