"""The mutations keep in touch with the code, and their runner tells what it should."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.mutation.__main__ import ALL, ROOT, main, run
from tests.mutation.mutation import Mutation, check, mutated

HALF = Mutation("half", "area.py", "a * b", "a * b / 2", ("test_area.py",))
EVEN = Mutation("even", "area.py", "return a", "return +a", ("test_area.py",))


@pytest.fixture
def tree(tmp_path):
    (tmp_path / "area.py").write_text("def area(a, b):\n    return a * b\n")
    (tmp_path / "test_area.py").write_text(
        "from area import area\n\ndef test_area():\n    assert area(2, 3) == 6\n"
    )
    return tmp_path


def test_every_mutation_is_found_in_the_code():
    """Each old text once, each test there, names unique; and as many as are said to be."""
    check(ALL, ROOT)
    assert len(ALL) >= 60
    for package in ("scaling/", "dem/", "scaling/symbolic/"):
        assert sum(m.file.startswith(package) for m in ALL) >= 8


@pytest.mark.nightly
def test_the_noticed_and_the_unnoticed_are_told_apart(tree, capsys):
    before = (tree / "area.py").read_text()
    assert run([HALF], tree) == []
    assert run([EVEN], tree) == ["even"]
    assert run([replace(EVEN, equivalent="a sign of plus")], tree) == []
    (wrong,) = run([replace(HALF, equivalent="said, but not so")], tree)
    assert "noticed" in wrong
    said = capsys.readouterr().out
    assert "half: killed" in said
    assert "even: SURVIVED" in said
    assert (tree / "area.py").read_text() == before


@pytest.mark.parametrize(
    ("mutations", "message"),
    [
        ([replace(HALF, old="a + b")], "'a \\+ b' 0 times"),
        ([replace(HALF, old="a")], "'a' 4 times"),
        ([replace(HALF, new=HALF.old)], "old and new text are the same"),
        ([replace(HALF, tests=("test_volume.py",))], "there is no test_volume.py"),
        ([HALF, HALF], "two mutations of this name"),
    ],
)
def test_a_list_out_of_touch_is_refused(tree, mutations, message):
    with pytest.raises(ValueError, match=message):
        run(mutations, tree)


def test_tests_that_fail_anyway_prove_nothing(tree):
    (tree / "test_area.py").write_text("def test_area():\n    assert False\n")
    with pytest.raises(RuntimeError, match="on the code as it is"):
        run([HALF], tree)


def test_unknown_mutations_are_refused_by_name(capsys):
    with pytest.raises(SystemExit):
        main(["--only", "phrenology"])
    assert "phrenology: no such mutation; there are noise of diameters" in capsys.readouterr().err
    assert mutated(HALF, "a * b") == "a * b / 2"
