"""Files that are written: where, and over what; one JSON for one question."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from packing.measurement import Measurement
from packing.writing import write
from packing_forces.answers.answer import Refused
from packing_forces.answers.file_names import stem, to_write
from tests.conftest import packing


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("a.npz", "a"), ("in/hooke.atoms.dump.gz", "hooke"), ("a.grains.csv", "a"),
        ("p=0.001.npz", "p=0.001"), ("dump.200", "dump.200"), (".npz", ".npz"), ("atoms", "atoms"),
    ],
)  # fmt: skip
def test_numbers_in_names_are_no_endings(path, name):
    """Else packings at 0.001 and at 0.002 would be answered in one file."""
    assert stem(path) == name


def test_what_was_given_is_not_written_over(tmp_path):
    given = SimpleNamespace(file=str(tmp_path / "a.csv"), contacts=str(tmp_path / "b.csv"))
    for name in ("a.csv", "b.csv"):
        with pytest.raises(Refused, match=f"{name}: would be written over"):
            to_write(tmp_path / "." / name, given)
    tables = SimpleNamespace(file=str(tmp_path / "m.grains.csv"), contacts=None)
    with pytest.raises(Refused, match=r"m\.contacts\.csv: would be written over"):
        to_write(tmp_path / "m.contacts.csv", tables)
    assert to_write(tmp_path / "new" / "c.csv", given).parent.is_dir()


def test_reading_a_table_leaves_it_as_it_is(ask, tmp_path):
    """It is no packing at rest, so tables would be written, by the names of those given."""
    made = packing(grains=40, delta=1e-2)
    only = Measurement(made.positions, made.radii, cell=made.cell)
    (table,) = write(tmp_path / "mine.csv", only)
    before = table.read_bytes().replace(b"# grains", b"# a remark; grains", 1)
    table.write_bytes(before)
    code, out, _ = ask("read", table.name)
    assert (code, table.read_bytes()) == (0, before)
    assert "nothing to write" in out
    assert ask("read", table.name, "--out", "mine.csv")[0] == 1
    assert table.read_bytes() == before
    assert ask("read", table.name, "--out", "other.npz")[0] == 0
    assert (tmp_path / "other.grains.csv").exists()


def test_a_packing_at_rest_becomes_tables_where_they_are_asked_for(ask, files, tmp_path):
    code, out, _ = ask("read", files / "packing.npz", "--out", "p.csv", "--json")
    assert (code, out["out"]) == (0, ["p.grains.csv", "p.contacts.csv"])
    assert (tmp_path / "p.grains.csv").read_text().startswith("# grains")
    assert not (tmp_path / "p.csv").exists()


def test_many_files_are_one_json(ask, files):
    code, out, _ = ask("check", files / "packing.npz", "gone.npz", "--json")
    assert code == 1
    assert [answer["file"] for answer in out] == ["packing.npz", "gone.npz"]
    assert "refused" in out[1]
    assert "refused" not in out[0]


def test_a_folder_is_no_file(ask, files):
    for words in ((".",), (files / "atoms.dump", "--contacts", ".")):
        code, _, err = ask("check", *words)
        assert code == 1
        assert ".: a folder, and no file" in err
