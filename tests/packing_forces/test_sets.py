"""Every verb on every set of another group ends with a result or a named refusal, as docs say."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.packing.foreign import foreign
from tests.packing_forces.sets import SETS, words

PAGE = Path(__file__).resolve().parents[2] / "docs" / "real_data.md"


def present(name):
    """The words for a set; skip where it is not at hand, by name."""
    found = words(SETS[name], foreign())
    if not Path(found[0]).exists():
        pytest.skip(f"{name} is in neither PACKING_DATA nor ../shared/data")
    return found


@pytest.mark.parametrize("name", SETS)
def test_verbs_end_with_a_result_or_a_named_refusal(ask, name):
    """read, check and forces; the row of the docs says what they said."""
    said = present(name)
    code, read, _ = ask("read", *said, "--json")
    assert code == 0
    code, check, _ = ask("check", *said, "--json")
    assert code == (0 if check["forces"] else 1)
    method = ("--method", "gppsz")  # the one that is chosen of exact data, without a look around
    code, forces, err = ask("forces", *said, *method, "--json")
    if code == 0:
        found = f"gppsz, E = {forces['true_error']:.0e}"
    else:
        assert forces["refused"] in err
        found = f"refused: {forces['refused'].partition(': ')[2].partition(': ')[0]}"
    able = "yes" if check["forces"] else "no"
    row = f"| {name} | {read['kind']}, {read['grains']}, {read['contacts']} | {able} | {found} |"
    (line,) = (x for x in PAGE.read_text("utf-8").splitlines() if x.startswith(f"| {name} |"))
    cut = row.rpartition("E = ")[0] or row
    assert line.startswith(cut), row
    if code == 0:  # an error of rounding need not be the same to its digit elsewhere
        stated = float(line.rpartition("E = ")[2].strip(" |"))
        assert forces["true_error"] < 30 * stated


def test_a_report_of_every_kind(ask, tmp_path):
    """One that is answered and one that is refused, both written."""
    for name, code in (("mercury_square", 0), ("photoelastic_shear", 1)):
        assert ask("report", *present(name), "--out", f"{name}.html")[0] == code
        assert "<h2" in (tmp_path / f"{name}.html").read_text("utf-8")
