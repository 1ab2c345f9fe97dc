"""What is told, and what the file shows: where both cannot be, no number goes out unmarked."""

from __future__ import annotations

import numpy as np
import pytest

from dem import Scene, relax
from packing.diagnosis import diagnose
from packing.measurement import Measurement
from packing.writing import write
from packing_forces.answers.words import percent
from tests.conftest import packing
from tests.packing_forces.dumps import write_dumps


@pytest.mark.parametrize("words", [("--stiffness", "1000"), ("--stiffness", "0.9")])
def test_a_stiffness_that_the_forces_deny_is_refused(ask, files, words):
    code, _, err = ask("check", files / "packing.npz", *words)
    assert code == 1
    assert f"--stiffness {words[1]} makes of the overlaps" in err


def test_a_stiffness_that_agrees_is_taken(ask, files):
    code, out, _ = ask("check", files / "packing.npz", "--stiffness", "1.01", "--json")
    assert code == 0
    assert out["law"] == "linear springs, κ = 1.01"


def test_a_pressure_that_the_forces_deny_is_refused(ask, files):
    code, _, err = ask("check", files / "packing.npz", "--pressure", "1")
    assert code == 1
    assert "--pressure 1 is 3.33e+04 times that of the forces of the file, 3e-05" in err
    assert ask("check", files / "packing.npz", "--pressure", "3.3e-5")[0] == 0


def test_forces_that_leave_grains_unbalanced_are_marked(ask, files):
    """Told that there is no friction, least squares leave what it bore; told nothing, nothing."""
    words = ("forces", files / "packing.npz", "--json")
    _, wrong, _ = ask(*words, "--friction", "0")
    _, right, _ = ask(*words)
    assert wrong["imbalance"] > 0.1
    assert "which such errors do not explain" in wrong["verdict"]
    assert "which such errors do not explain" not in right["verdict"]


def test_a_page_is_not_green_where_data_contradict(ask, files, tmp_path):
    """And says of exact lengths that all intervals hold the force, not 68 % of them."""
    words = ("report", files / "packing.npz", "--noise", "1e-8", "--method", "gppsz")
    assert ask(*words, "--out", "good.html")[0] == 0
    assert ask(*words, "--friction", "0", "--out", "bad.html")[0] == 0
    good, bad = ((tmp_path / f"{name}.html").read_text() for name in ("good", "bad"))
    assert 'class="verdict"' in good
    assert "100\u00a0% of the intervals of f_n hold the true force; all should" in good
    assert 'class="verdict no"' in bad
    assert "all should" not in bad


def test_warnings_of_the_file_stand_beside_its_forces(ask, files):
    _, out, _ = ask("forces", files / "atoms.dump", "--stiffness", "1", "--method", "gppsz")
    assert "there is no list of contacts [no-contacts]" in out
    _, out, _ = ask("forces", files / "packing.npz")
    assert "warning" not in out


def test_every_guess_is_said(ask, tmp_path):
    """Columns and friction are two, by one name; friction that was told is no guess."""
    atoms, contacts = write_dumps(packing(grains=40, delta=1e-2), tmp_path)
    words = (atoms, "--contacts", contacts, "--json")
    guesses = lambda out: [n["text"] for n in out["notes"] if n["name"] == "guessed"]  # noqa: E731
    _, read, _ = ask("read", *words)
    assert any("are the grains" in said for said in guesses(read))
    told = ("--stiffness", "1", "--noise", "1e-3", "--draws", "8")
    for friction, guessed in (((), True), (("--friction", "0.3"), False)):
        _, out, _ = ask("forces", *words, *told, *friction)
        assert out["method"] == "bounded"
        assert any(said.startswith("friction") for said in guesses(out)) == guessed
        assert ("the largest f_t/f_n of the file" in out["why"]) == guessed


def test_no_error_is_below_that_of_a_double():
    assert percent(3.6e-31) == "less than 1e-16"
    assert percent(2e-16) == "2e-16"
    assert percent(0.0) == "0"


def test_hertz_is_told_by_its_own_constant(ask, tmp_path):
    """κ of f = κ δ^(3/2) is 1; the slope of a contact at the pressure is another number."""
    spheres = relax(Scene(grains=40, delta=1e-2, contact="hertz"), 1, progress=False)
    spheres.save(tmp_path / "spheres.npz")
    _, out, _ = ask("read", "spheres.npz")
    assert "elastic spheres, κ = 1, ν = 0.3, pressure" in out
    assert "stiffness =" not in out


def test_gaps_do_not_show_an_error_of_forces():
    made = packing(grains=40, delta=1e-2)
    rows = {
        name: Measurement(
            np.round(made.positions, 3), factor * made.radii, cell=made.cell, pairs=made.pairs,
            images=made.images,
        )
        for name, factor in (("overlaps", 1.0), ("gaps", 0.97))
    }  # fmt: skip
    said = {
        name: next(n for n in diagnose(data) if n.name == "coarse-coordinates")
        for name, data in rows.items()
    }
    assert "an error of E ≈" in said["overlaps"].text
    assert "No overlap shows" in said["gaps"].text
    assert said["gaps"].number is None


def test_commas_of_numbers_among_commas_of_tables_are_named(ask, tmp_path):
    (tmp_path / "de.csv").write_text("id,x,y,r\n0,1,5,2,5,0,5\n1,2,5,2,5,0,5\n")
    code, _, err = ask("read", "de.csv")
    assert code == 1
    assert "decimal comma [decimal-comma]" in err
    (tmp_path / "long.csv").write_text("id,x,y,r\n0,1.5,2.5,0.5,7\n")
    assert "[uneven-rows]" in ask("read", "long.csv")[2]


def test_utf_16_is_recognised(ask, tmp_path):
    """By its beginning too, where that is a remark."""
    text = "# sizes in mm\nid,x,y,r\n0,1.5,2.5,0.5\n"
    (tmp_path / "u.csv").write_bytes(text.encode("utf-16"))
    code, out, _ = ask("read", "u.csv", "--json")
    assert (code, out["grains"]) == (0, 1)


def test_advice_is_in_words_of_the_command_line(ask, tmp_path):
    (tmp_path / "prose.txt").write_text("Once upon a time\n")
    assert "say --format [unknown-format]" in ask("read", "prose.txt")[2]
    (tmp_path / "c.csv").write_text("i,j,fn\n0,1,1.0\n")
    assert "this one by --contacts" in ask("read", "c.csv")[2]


def test_need_takes_one_poisson_ratio(ask):
    code, _, err = ask("need", "--material", "glass", "--pressure", "1", "--poisson", "0.1")
    assert (code, "--material has its own" in err) == (1, True)
    words = ("need", "--modulus", "1e9", "--pressure", "1")
    assert ask(*words)[1] == ask(*words, "--poisson", "0.3")[1] != ask(*words, "--poisson", "0")[1]


def test_a_table_of_the_other_sign_is_named(ask, tmp_path):
    """Nothing but the sign of f_n and f_t is another than in a packing at rest."""
    made = packing(grains=40, delta=1e-2)
    reversed_ = [-made.normal_forces, -made.tangential_forces]
    grains, _ = write(tmp_path / "m.csv", made, forces=np.concatenate(reversed_))
    assert "is compression negative in this file?" in ask("check", grains)[1]
    again, _ = write(tmp_path / "n.csv", made)
    assert "compression" not in ask("check", again)[1]


def test_lengths_are_not_known_to_a_delta_that_is_not_known(ask, tmp_path):
    made = packing(grains=40, delta=1e-2)
    only = Measurement(made.positions, made.radii, cell=made.cell)
    (table,) = write(tmp_path / "mine.csv", only)
    _, out, _ = ask("forces", table, "--stiffness", "1")
    assert "lengths are known so well: Eq. 1 as it stands" in out
