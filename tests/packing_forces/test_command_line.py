"""The front door: exit codes, help, what is printed, what is loaded."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from packing.contact_law import Hertz, Linear, PerContact
from packing.contact_law.material import MATERIALS
from packing_forces.known.case import law_in_words
from packing_forces.options import FIGURES as COUNT
from packing_forces.options import MATERIALS as NAMED
from packing_forces.options import METHODS, VERBS
from paper_figs.__main__ import FIGURES
from scaling.estimators.table import ESTIMATORS


@pytest.mark.parametrize("words", [["--help"], *([verb, "--help"] for verb in VERBS)])
def test_help_loads_neither_scipy_nor_matplotlib(words):
    code = (
        "import sys\nfrom packing_forces.command_line import main\n"
        f"try:\n    main({words!r})\nexcept SystemExit as left:\n    assert left.code == 0\n"
        "print([m for m in ('scipy', 'matplotlib', 'numpy') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "[]"
    assert words[0] == "--help" or f"packing-forces {words[0]} " in run.stdout


def test_a_verb_does_load_them():
    """The control: what the test above looks for is there once a verb has been asked."""
    code = (
        "import sys\nfrom packing_forces.command_line import main\nmain(['check', 'none.npz'])\n"
        "print('scipy' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "True"


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_an_example(ask, verb):
    code, out, _ = ask(verb, "--help")
    assert code == 0
    assert out.rstrip().endswith(VERBS[verb].example)
    assert VERBS[verb].example.startswith(f"packing-forces {verb} ")


def test_laws_are_said_in_a_few_words():
    """However many contacts they are of."""
    assert law_in_words(None) == "no contact law"
    assert law_in_words(Linear(2.0)) == "linear springs, κ = 2"
    assert law_in_words(PerContact(np.array([1.0, 3.0]))) == "linear springs, κ = 1 to 3"
    spheres = Hertz(5.0).of_contacts(np.full(500, 0.25))
    assert law_in_words(spheres) == "elastic spheres, κ = 5, ν = 0.3"


def test_names_are_those_of_the_packages():
    """Written out where nothing may be loaded, so they have to be held together here."""
    assert set(METHODS) == set(ESTIMATORS)
    assert set(NAMED) == set(MATERIALS)
    assert len(FIGURES) == COUNT


@pytest.mark.parametrize(
    "words",
    [
        [], ["explain"], ["check"], ["check", "a", "--noise", "-1"],
        ["check", "a", "--noise", "x"],
        ["forces", "a", "--method", "magic"], ["figure", "9"], ["figure", "six"],
        ["need", "--modulus", "0"], ["prepare"], ["read", "a", "--set", "radius"],
        ["check", "a", "--gap", "inf"],
        ["prepare", "packing.txt"], ["report", "a", "--out", "a.npz"],
        ["forces", "a", "--out", "a.npz"], ["forces", "a", "--picture", "a.doc"],
        ["forces", "a", "--draws", "0"], ["forces", "a", "--draws", "7"],
        ["forces", "a.npz", "b.npz", "--out", "both.csv"], ["forces", "a.npz", "in/a.npz"],
    ],
)  # fmt: skip
def test_wrong_usage_is_2(ask, words):
    code, out, err = ask(*words)
    assert (code, out) == (2, "")
    assert "usage: packing-forces" in err


@pytest.mark.parametrize("verb", ["read", "check", "forces", "report"])
def test_a_file_that_is_none_is_1_and_named(ask, tmp_path, verb):
    code, out, err = ask(verb, "gone.npz")
    assert (code, out) == (1, "")
    assert err.startswith(f"packing-forces {verb}: gone.npz: ")
    (tmp_path / "noise.dump").write_bytes(bytes(range(256)) * 9)
    code, out, err = ask(verb, "noise.dump", "--json")
    assert code == 1
    assert "noise.dump" in out["refused"]
    assert out["refused"] in err


def test_several_files_end_with_the_worst_code(ask, files):
    code, out, err = ask("check", files / "packing.npz", "gone.npz")
    assert code == 1
    assert "Can forces be had? Yes" in out
    assert "gone.npz" in err


def test_module_and_version():
    run = [sys.executable, "-m", "packing_forces", "--version"]
    found = subprocess.run(run, capture_output=True, text=True, check=True)
    assert found.stdout.startswith("packing-forces 0")
