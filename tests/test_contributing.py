"""The examples of CONTRIBUTING.md are what they say: new laws, estimators and formats work."""

from __future__ import annotations

import re

import numpy as np
import pytest

from dem.model.confinement import BOUNDARIES
from packing.files.formats.table import FORMATS
from packing.files.problem import FileProblem
from packing.reading import read
from scaling import ContactNetwork, error_map, force_equation, perturb, reconstruct
from scaling.estimators.table import ESTIMATORS
from tests.conftest import packing
from tests.markdown import ROOT, run
from tests.test_layers import climbing, house


@pytest.fixture
def made(monkeypatch, tmp_path):
    """The names that the examples define, run in an empty folder; the table stays as it is."""
    monkeypatch.chdir(tmp_path)
    tables = (ESTIMATORS, FORMATS, BOUNDARIES)
    before = [dict(table) for table in tables]
    yield run(ROOT / "CONTRIBUTING.md")
    for table, entries in zip(tables, before, strict=True):
        table.clear()
        table.update(entries)


def test_the_law_is_one(made):
    """`overlap` undoes `force`, `slope` is its derivative, both odd."""
    law = made["Stiffening"](stiffness=3.0, doubling=0.1)
    δ = np.array([-0.2, -1e-9, 0.0, 1e-9, 1e-3, 0.3])
    np.testing.assert_allclose(law.overlap(law.force(δ)), δ, rtol=1e-14)
    step = 1e-7
    slope = (law.force(δ + step) - law.force(δ - step)) / (2 * step)
    np.testing.assert_allclose(law.slope(δ), slope, rtol=1e-5)


def test_the_law_is_found_by_eq_1_and_not_taken_for_linear(made):
    """Controls: the linear law of the same κ is off, and `optimal` refuses."""
    law, network = made["Stiffening"](doubling=1e-3), network_of_overlaps()
    forces = law.force(network.overlaps)
    assert reconstruct(network, law, "direct").normal == pytest.approx(forces)
    assert reconstruct(network, 1.0, "direct").normal != pytest.approx(forces, rel=0.1)
    with pytest.raises(ValueError, match="linear laws only"):
        reconstruct(network, law, "optimal", xi=1e-6)


def network_of_overlaps() -> ContactNetwork:
    return ContactNetwork.from_packing(packing(grains=48, delta=1e-3))


def test_the_estimator_responds_as_it_finds(made):
    """E η of its error map is the difference of two solutions, for noise on sizes."""
    made_of = packing(grains=48, delta=1e-3)
    network = ContactNetwork.from_packing(made_of)
    noisy = perturb(network, 1e-5, np.random.default_rng(1))
    η = 2 * (noisy.radii - network.radii) / (1e-5 * network.mean_diameter)
    estimator = made["Weighted"](weight=3.0)
    found = [estimator.solve(force_equation(n).with_law(1.0)).forces for n in (network, noisy)]
    expected = 1e-5 * error_map(network, "weighted", weight=3.0).matrix @ η
    np.testing.assert_allclose(found[1] - found[0], expected, atol=1e-9 * abs(expected).max())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"positions": []}\n', r"half\.json: radii is missing"),
        ('{"positions":\n[[0.1, 0.2\n', r"half\.json, line 2: Expecting ',' delimiter"),  # cut off
        ('{"positions"', r"half\.json, line 1: the last line does not end"),
        ("", r"half\.json: the file is empty"),
    ],
)
def test_the_format_names_the_file_that_lacks_something(made, tmp_path, text, message):
    (tmp_path / "half.json").write_text(text)
    with pytest.raises(ValueError, match=message):
        made["read"](tmp_path / "half.json")


def test_the_format_is_one_of_all(made, tmp_path):
    """Recognised, read to the bit, and refused like the others where it is damaged."""
    p = packing(grains=48, delta=1e-3)
    made["write"](tmp_path / "p.json", p)
    for options in ({}, {"format": "json"}):
        found = read(tmp_path / "p.json", **options)
        assert np.array_equal(found.forces, p.forces)
        assert np.array_equal(found.cell, p.cell)
    half = (tmp_path / "p.json").read_text().replace("pressure", "temperature")
    (tmp_path / "p.json").write_text(half)
    with pytest.raises(FileProblem, match="pressure is missing"):
        read(tmp_path / "p.json")


NEW_FILE = re.compile(
    r"new file `([\w/]+)\.py`.*?\n```python\n(.*?)^```", re.DOTALL | re.MULTILINE
)


def new_files() -> dict[str, str]:
    """Name of the module -> its text, for the files that the examples make."""
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return {m[1].replace("/", "."): m[2] for m in NEW_FILE.finditer(page)}


@pytest.mark.parametrize("name", new_files())
def test_a_new_file_stands_alone_in_its_room(name, tmp_path):
    """It runs by itself, has a docstring, and imports from below only."""
    names = {"__name__": name}
    exec(compile(new_files()[name], name, "exec", dont_inherit=True), names)
    assert names["__doc__"]
    module = tmp_path / "module.py"
    module.write_text(new_files()[name])
    assert climbing(house() | {name: module}) == []


def test_there_are_three_new_files():
    assert sorted(n.rpartition(".")[0] for n in new_files()) == [
        "packing.contact_law",
        "packing.files.formats",
        "scaling.estimators",
    ]


def test_a_format_that_imports_the_record_climbs(tmp_path):
    """Control: it was so once."""
    module = tmp_path / "module.py"
    module.write_text("from packing.record import Packing\n")
    wrong = climbing(house() | {"packing.files.formats.new": module})
    assert wrong == ["packing.files.formats.new imports packing.record"]


def test_the_vice_presses_with_one_wall_alone(made):
    """The pressed wall bears its load, the others are held where they stood. Control: the load of
    another wall is nobody's."""
    p = made["squeezed"]
    assert p.walls.known.tolist() == [3]
    assert p.wall_forces()[3].real == pytest.approx(p.walls.loads[3], rel=1e-10)
    top = p.wall_forces()[1].imag
    assert top > 0
    assert abs(top / p.walls.loads[3] - 1) > 1e-3
    assert p.walls.offsets[1] > p.walls.offsets[3]  # the right wall has moved in, the top has not
