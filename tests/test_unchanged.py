"""The comparing script sees what differs, and only that."""

from __future__ import annotations

import numpy as np
import pytest

from tests.unchanged import compare


@pytest.fixture
def frozen(tmp_path):
    """Two folders with the same results."""
    for name in ("before", "after"):
        (tmp_path / name).mkdir()
        np.savez(tmp_path / name / "packing00.npz", radii=np.array([0.5, 0.6]))
        (tmp_path / name / "t.csv").write_text("method,E\ngppsz,0.1\nbounded,0.2\n")
    return tmp_path


def test_the_same_results(frozen):
    (frozen / "after" / "t.csv").write_text(
        "# how\nmethod,more,E\ngppsz,1,0.10000000001\nbounded,1,0.2000001\n"
    )
    assert compare(frozen / "before", frozen / "after") == []


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("method,E\ngppsz,0.1000000002\nbounded,0.2\n", "t.csv, row 0: E = 0.1 became"),
        ("method,E\ngppsz,0.1\nbounded,0.200001\n", "t.csv, row 1"),
        ("method,E\ngppsz,0.1\n", "t.csv: 2 rows became 1"),
        ("method\ngppsz\nbounded\n", "t.csv, row 0: E = 0.1 became nothing"),
    ],
)
def test_a_table_that_differs(frozen, table, message):
    (frozen / "after" / "t.csv").write_text(table)
    (found,) = compare(frozen / "before", frozen / "after")
    assert found.startswith(message)


def test_a_packing_that_differs_in_its_last_bit(frozen):
    np.savez(frozen / "after" / "packing00.npz", radii=np.array([0.5, np.nextafter(0.6, 1)]))
    assert compare(frozen / "before", frozen / "after") == ["packing00.npz: radii differs"]


def test_nothing_to_compare_with_is_no_success(tmp_path):
    with pytest.raises(ValueError, match="holds nothing to compare with"):
        compare(tmp_path, tmp_path)
