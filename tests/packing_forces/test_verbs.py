"""What the verbs answer: numbers that are those of the library, and refusals that name why."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from dem import Packing, Scene, relax
from packing_forces.judging.need import FLAT_GUESS, PREFACTORS
from packing_forces.judging.table import COLUMNS
from scaling import (
    ContactNetwork,
    amplification_of,
    error_map,
    mean_force,
    perturb,
    reconstruct,
    relative_error,
)
from studies.packing_store import FULL
from studies.tables import read_table
from tests.conftest import packing


def dumps(files):
    return files / "atoms.dump", "--contacts", files / "contacts.dump"


KNOWN = ("--stiffness", "1", "--friction", "0.3")


def test_read_says_what_it_understood_and_writes_it(ask, files, tmp_path):
    code, out, _ = ask("read", *dumps(files), "--out", "mine.npz")
    assert code == 0
    assert "atoms.dump: a measurement" in out
    assert "80 grains" in out
    assert "six-digit-coordinates" in out
    assert {p.name for p in tmp_path.iterdir()} == {"mine.grains.csv", "mine.contacts.csv"}
    code, again, _ = ask("read", "mine.grains.csv", "--contacts", "mine.contacts.csv", "--json")
    assert (code, again["kind"]) == (0, "measurement")
    assert "normal_forces" in again["known"]
    code, out, _ = ask("read", files / "packing.npz", "--json")
    assert (code, out["kind"], out["out"]) == (0, "packing", ["packing.npz"])
    assert np.array_equal(
        Packing.load(tmp_path / "packing.npz").radii, packing(80, 3e-5, seed=3).radii
    )


def test_check_counts_and_says_yes(ask, files):
    p = packing(grains=80, delta=3e-5, seed=3)
    code, out, _ = ask("check", files / "packing.npz", "--json")
    assert (code, out["forces"]) == (0, True)
    assert (out["contacts"], out["rattlers"]) == (len(p.pairs), int(p.rattlers.sum()))
    assert out["delta"] == pytest.approx(3e-5)
    assert out["checks"]["balance"]["value"]["force"] < 1e-9
    assert out["checks"]["Coulomb"]["value"] <= 0.3 * (1 + 1e-6)
    assert out["checks"]["rank"]["said"].startswith(f"rank {2 * len(p.pairs)} of")


def test_check_says_no_where_noise_is_too_strong(ask, files):
    """ξ = Δ/100 can be had, ξ = 3 Δ cannot, and the error is that of the error map."""
    p = packing(grains=80, delta=3e-5, seed=3)
    code, out, _ = ask("check", files / "packing.npz", "--noise", 3e-7, "--json")
    assert code == 0
    C = amplification_of(p, noise="position")
    assert out["checks"]["error"]["value"] == pytest.approx(0.01 * C, rel=1e-6)
    code, out, _ = ask("check", files / "packing.npz", "--noise", 9e-5)
    assert code == 1
    assert "Not from geometry alone" in out


def test_check_names_what_is_missing(ask, tmp_path):
    """Two rows of an open square: no loads; loads that do not balance are another refusal."""
    p = packing(grains=80, delta=3e-5, seed=3)
    inner = ContactNetwork.from_packing(p)
    assert inner.contacts
    lines = ["ITEM: TIMESTEP", "0", "ITEM: NUMBER OF ATOMS", "4", "ITEM: BOX BOUNDS ff ff pp"]
    lines += ["-9 9", "-9 9", "-0.5 0.5", "ITEM: ATOMS id type radius x y z"]
    lines += [f"{k + 1} 1 0.5 {0.99 * (k % 2)} {0.99 * (k // 2)} 0" for k in range(4)]
    (tmp_path / "open.dump").write_text("\n".join(lines) + "\n")
    code, out, _ = ask("check", "open.dump", "--stiffness", "1")
    assert code == 1
    assert "no load is known" in out
    code, out, err = ask("forces", "open.dump", "--stiffness", "1")
    assert (code, out) == (1, "")
    assert "what holds the rim is missing" in err


def test_diameters_for_radii_are_refused_by_name(ask, files, tmp_path):
    """By every verb; told as diameters they are taken."""
    lines = (files / "atoms.dump").read_text().splitlines()
    start = lines.index("ITEM: ATOMS id type radius x y z") + 1
    rows = [line.split() for line in lines[start:]]
    doubled = [" ".join([*row[:2], str(2 * float(row[2])), *row[3:]]) for row in rows]
    (tmp_path / "twice.dump").write_text("\n".join([*lines[:start], *doubled]) + "\n")
    said = ("twice.dump", "--contacts", files / "contacts.dump", *KNOWN)
    for verb in ("check", "forces", "report"):
        code, out, err = ask(verb, *said)
        assert code == 1, verb
        assert "diameters-for-radii" in out + err
    assert ask("check", *said, "--set", "sizes='diameters'")[0] == 0


def test_forces_of_six_digits_have_bars_and_advice(ask, files, tmp_path):
    """The verdict's numbers are those of the network at hand; the CSV holds true forces."""
    p = packing(grains=80, delta=3e-5, seed=3)
    code, out, _ = ask("forces", *dumps(files), *KNOWN, "--method", "gppsz", "--json")
    assert code == 0
    assert out["xi_source"].startswith("rounding: positions 6 digits")
    assert out["true_error"] < 3 * out["error"]
    assert "Write dumps with %.10g" in out["verdict"]
    with (tmp_path / "atoms-forces.csv").open() as stream:
        rows = list(csv.reader(stream))
    assert tuple(rows[0]) == COLUMNS
    table = np.array(rows[1:], dtype=float)
    assert np.array_equal(table[:, :2].astype(int), p.pairs)
    low, high, mean = table[:, 7], table[:, 8], p.normal_forces.mean()
    assert ((low < table[:, 6]) & (table[:, 6] < high)).all()
    held = ((low < p.normal_forces) & (p.normal_forces < high)).mean()
    assert 0.4 < held <= 1
    assert np.abs(table[:, 6] - p.normal_forces).max() < mean


def test_forces_for_paraview(ask, files, tmp_path):
    code, _, err = ask("forces", files / "packing.npz", "--out", "chains.vtk")
    assert code == 0, err
    assert (tmp_path / "chains.vtk").read_text().startswith("# vtk")


def test_expected_errors_are_those_of_the_error_map(ask, files):
    """For position noise of 0.1 Δ, K κ ξ/⟨|f|⟩ of every linear method."""
    p = packing(grains=80, delta=3e-5, seed=3)
    n = ContactNetwork.from_packing(p)
    _, out, _ = ask(
        "forces", files / "packing.npz", "--noise", 3e-6, "--method", "gppsz", "--json"
    )
    for method in ("gppsz", "balanced", "direct", "optimal"):
        K = error_map(n, method, "position", forces=p.forces, stiffness=1.0).gain
        E = K * 3e-6 / mean_force(p)
        assert out["expected"][method] == pytest.approx(E, rel=2e-2)
    errors = [
        relative_error(reconstruct(perturb(n, 3e-6, np.random.default_rng(k), "position"), 1.0), p)
        for k in range(20)
    ]
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(out["expected"]["gppsz"], rel=0.3)


def test_the_best_method_is_chosen_for_a_reason(ask, files):
    pytest.importorskip("clarabel", reason="bounded needs clarabel")
    for words, method in (
        ((files / "packing.npz",), "gppsz"),
        ((*dumps(files), *KNOWN), "bounded"),
        ((*dumps(files), "--stiffness", "1"), "optimal"),
        ((*dumps(files), "--friction", "0.3"), "bounded"),
    ):
        _, out, _ = ask("forces", *words, "--draws", 8, "--json")
        assert out["method"] == method, words
        assert out["why"]
    assert out["delta"] is None  # no law was told: no length was used
    assert out["true_error"] < 0.5


def test_bounded_with_bars_is_no_worse_than_it_says(ask, files):
    pytest.importorskip("clarabel", reason="bounded needs clarabel")
    _, out, _ = ask("forces", *dumps(files), *KNOWN, "--draws", 12, "--json")
    assert out["true_error"] < 3 * out["error"]
    assert out["error"] < out["expected"]["gppsz"]


def test_a_contradiction_is_said(ask, files):
    """Noise told thirty times too small: the misfit says it, and the verdict does."""
    code, out, _ = ask("forces", *dumps(files), *KNOWN, "--noise", 1e-7, "--method", "optimal")
    assert code == 0
    assert "contradict what was told" in out


def test_exact_lengths_are_said_to_be_exact(ask, files):
    """Noise that is told of exact data is not in them; six digits are."""
    said = "Its lengths are exact"
    told = ("--method", "optimal", "--noise", "3e-6")
    assert said in ask("forces", files / "packing.npz", *told)[1]
    assert said not in ask("forces", *dumps(files), *KNOWN, *told)[1]


@pytest.mark.parametrize("part", [0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99])
@pytest.mark.parametrize("name", ["atoms.dump", "contacts.dump"])
def test_half_a_file_is_refused_by_name(ask, files, tmp_path, name, part):
    for file in ("atoms.dump", "contacts.dump"):
        text = (files / file).read_bytes()
        (tmp_path / file).write_bytes(text[: int(part * len(text))] if file == name else text)
    code, out, err = ask("check", "atoms.dump", "--contacts", "contacts.dump", *KNOWN)
    assert (code, out) == (1, "")
    assert err.startswith("packing-forces check: ")
    assert name in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--method", "optimal", "--noise", "0"), "optimal needs the noise"),
        (("--pressure", "2.4e-5", "--method", "bounded", "--noise", "1e-12"), "bounded: "),
    ],
)
def test_refusals_name_what_is_missing(ask, files, words, said):
    code, out, err = ask("forces", files / "packing.npz", *words)
    assert (code, out) == (1, "")
    assert said in err


def test_no_law_and_no_friction_is_refused(ask, files):
    code, _, err = ask("forces", *dumps(files))
    assert code == 1
    assert "give --stiffness κ, or --friction μ" in err


def test_pictures_are_drawn(ask, files, tmp_path):
    code, out, _ = ask("forces", files / "packing.npz", "--picture", "chains.png")
    assert code == 0
    assert "drawn to chains.png" in out
    assert (tmp_path / "chains.png").stat().st_size > 5000


def test_prepare_makes_a_packing_at_rest(ask, tmp_path):
    words = ("--grains", 40, "--delta", "1e-2", "--boundary", "walls", "--quiet")
    code, out, _ = ask("prepare", "new.npz", *words, "--json")
    assert code == 0
    made = Packing.load(tmp_path / "new.npz")
    assert len(made.radii) >= 40
    assert made.walls is not None
    assert out["residual"] < 1e-8
    code, _, err = ask("prepare", "bad.npz", "--grains", 2)
    assert code == 1
    assert "grains = 2" in err


def test_need_is_the_scaling_law(ask):
    """ξ = E Δ/C: ten times the error, ten times the noise; Δ of Hertz goes as p^(2/3)."""
    _, one, _ = ask("need", "--material", "glass", "--pressure", "1e3", "--json")
    _, ten, _ = ask("need", "--material", "glass", "--pressure", "1e3", "--error", "1", "--json")
    of, more = (x["precision"]["diameter"]["gppsz"] for x in (one, ten))
    assert more == pytest.approx(10 * of)
    assert of == pytest.approx(0.1 * one["delta"] / (1.5 * 0.33))
    _, far, _ = ask("need", "--material", "glass", "--pressure", "8e3", "--json")
    assert far["delta"] == pytest.approx(4 * one["delta"])
    plane = 7.0e10 / (1 - 0.22**2)
    assert one["delta"] == pytest.approx((3e3 / plane) ** (2 / 3))
    _, said, _ = ask("need", "--material", "glass", "--pressure", "2e3", "--diameter", "1e-3")
    assert "3.8 nm (gppsz)" in said
    _, linear, _ = ask(
        "need", "--modulus", "1e6", "--pressure", "1e3", "--law", "linear", "--json"
    )
    assert linear["delta"] == pytest.approx(1e3 * (1 - 0.09) / 1e6)
    assert set(linear["precision"]["position"]) == {"gppsz", "balanced", "direct", "optimal"}
    assert set(one["precision"]["position"]) == {"gppsz", "direct"}  # others take no Hertz


def test_need_of_spheres_is_that_of_packings_of_spheres(ask):
    """C of a packing of elastic spheres, from its error map, lies by that of `need`, and 1.5 times
    below it does not."""
    spheres = relax(Scene(grains=80, delta=1e-3, contact="hertz"), 3, progress=False)
    _, out, _ = ask("need", "--modulus", "1e8", "--pressure", "1e3", "--json")
    told = 0.1 * out["delta"] / out["precision"]["diameter"]["gppsz"]
    found = amplification_of(spheres)
    assert 0.8 < found / told < 1.25
    assert found / (told / 1.5) > 1.25


def test_prefactors_of_need_are_those_of_the_figure():
    """Written out, since a wheel has no tables; to their two digits those of Fig. 4."""
    table = read_table(FULL.figures / "fig4.csv")
    table = table[table["ratio"] == 0.01]
    for noise, by in PREFACTORS.items():
        for method, told in by.items():
            mine = table[(table["noise"] == noise) & (table["method"] == method)]
            found = [mine["error"][mine["delta"] == d][0] / 0.01 for d in (1e-2, 1e-4, 1e-6)]
            assert told == pytest.approx(found, rel=0.03), (noise, method)
    assert pytest.approx(table["flat"].mean(), rel=0.03) == FLAT_GUESS


def test_need_lists_materials_with_sources_and_refuses_the_impossible(ask):
    code, out, _ = ask("need")
    assert code == 0
    for name in ("glass", "steel", "sand", "rubber", "photoelastic", "hydrogel"):
        assert f"\n{name}" in out
    assert "Ashby" in out
    for words, said in (
        (("--material", "hydrogel", "--pressure", "1e5"), "no contact of two disks"),
        (("--material", "glass"), "--pressure is needed"),
        (("--material", "glass", "--modulus", "1", "--pressure", "1"), "give one"),
        (("--modulus", "1", "--pressure", "1", "--poisson", "0.7"), "poisson = 0.7"),
    ):
        code, _, err = ask("need", *words)
        assert code == 1
        assert said in err
