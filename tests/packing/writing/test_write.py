"""What is written comes back bit for bit; what a format cannot hold is refused by name."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from dem.model.confinement import Strip
from packing.boundary import Walls
from packing.files.problem import FileProblem
from packing.measurement import Measurement, Uncertainty
from packing.reading import notes, read
from packing.record import Packing
from packing.writing import FORMATS, write
from tests.packing.sample_files import made

SCENES = st.sampled_from(
    [
        {},
        {"friction": 0.0},
        {"delta": 1e-4},
        {"contact": "hertz"},
        {"boundary": "box"},
        {"boundary": "walls", "gravity": 1e-4},
        {"boundary": Strip("rough")},
    ]
)


def same(p, q, names=None):
    """Every array and number of two packings, to the bit, walls among them."""
    for name in names or [f.name for f in fields(p) if f.name not in ("provenance", "walls")]:
        assert np.array_equal(getattr(p, name), getattr(q, name)), name
    assert (p.walls is None) == (q.walls is None)
    if p.walls is not None:
        for name in ("normals", "offsets", "loads", "glued"):
            a, b = getattr(p.walls, name), getattr(q.walls, name)
            assert (a is None and b is None) or np.array_equal(a, b, equal_nan=True), name


@given(SCENES, st.sampled_from(["npz", "csv"]))
def test_packings_come_back_bit_for_bit(tmp_path_factory, scene, kind):
    p = made(**scene)
    folder = tmp_path_factory.mktemp("p")
    found = read(write(folder / f"p.{kind}", p)[0])
    assert isinstance(found, Packing), [str(note) for note in notes(found)]
    same(p, found)
    assert np.array_equal(p.law.force(p.overlaps), found.law.force(found.overlaps))


LENGTHS = st.floats(-0.1, 0.1)
FORCES = st.floats(-1e6, 1e6) | st.floats(0, 1e-300) | st.just(-0.0)


@st.composite
def measurements(draw):
    """Grains near a square lattice, any contacts between neighbours, any forces or none."""
    n = draw(st.integers(2, 4))
    base = np.stack(np.meshgrid(np.arange(n), np.arange(n)), axis=-1).reshape(-1, 2)
    x = base + np.array(draw(st.lists(LENGTHS, min_size=2 * n * n, max_size=2 * n * n))).reshape(
        -1, 2
    )
    near = [(i, j) for i in range(n * n) for j in range(i) if abs(base[i] - base[j]).sum() == 1]
    pairs = np.sort(draw(st.lists(st.sampled_from(near), min_size=1, unique=True)), axis=1)
    c = len(pairs)
    forces = st.none() | st.lists(FORCES, min_size=c, max_size=c).map(np.array)
    normal = draw(forces)
    if normal is not None:
        normal = np.where(normal == 0, 1.0, normal)  # pairs without a force are left out
    angles = draw(st.none() | st.lists(st.floats(0, 6), min_size=c, max_size=c).map(np.array))
    walls = draw(
        st.sampled_from([None, Walls([[0.0, -1.0]], [0.7]), Walls([[1, 0]], [9.0], [2.5])])
    )
    radii = np.array(draw(st.lists(st.floats(0.4, 0.6), min_size=n * n, max_size=n * n)))
    return Measurement(
        x,
        radii=draw(st.sampled_from([None, radii])),
        pairs=pairs,
        walls=walls,
        normals=None if angles is None else np.column_stack([np.cos(angles), np.sin(angles)]),
        normal_forces=normal,
        tangential_forces=None if normal is None else draw(forces),
        stiffness=draw(st.none() | st.floats(0.1, 1e9)),
        friction=draw(st.none() | st.floats(0, 2)),
        length_unit=draw(st.sampled_from(["", "mm", "px"])),
    )


@given(measurements())
def test_measurements_come_back_bit_for_bit(tmp_path_factory, m):
    """Unless forces and overlaps contradict the stiffness, which is refused by name."""
    folder = tmp_path_factory.mktemp("m")
    path = write(folder / "m.csv", m)[0]
    try:
        found = read(path)
    except FileProblem as refused:
        event(refused.note.name)
        if refused.note.name == "units-mixed":
            return
        raise
    names = ["positions", "radii", "pairs", "images", "normal_forces"]
    same(m, found, [name for name in names if getattr(m, name) is not None])
    if m.tangential_forces is not None:
        assert np.array_equal(m.tangential_forces, found.tangential_forces)
    if isinstance(found, Measurement) and m.normals is not None:
        assert np.array_equal(m.normals, found.normals)
        assert (found.friction, found.length_unit) == (m.friction, m.length_unit)


def test_either_table_and_their_common_name_are_read(tmp_path):
    p = made()
    for path in (*write(tmp_path / "p.csv", p), tmp_path / "p.csv"):
        same(p, read(path))


def test_error_bars_come_back(tmp_path):
    p, c = made(), len(made().pairs)
    bars = np.random.default_rng(1).random(2 * c)
    given = np.random.default_rng(2).random(2 * c)
    m = read(write(tmp_path / "p.csv", p, forces=given, errors=bars)[0])
    assert isinstance(m, Measurement)  # such forces do not balance
    assert np.array_equal(m.normal_forces, given[:c])
    assert np.array_equal(m.uncertainty.normal_forces, bars[:c])
    assert np.array_equal(m.uncertainty.tangential_forces, bars[c:])


def test_uncertainty_of_pairs_that_are_left_out_is_left_out(tmp_path):
    """Error bars stay with their contacts when a row is dropped."""
    p, c = made(), len(made().pairs)
    given, bars = p.forces.copy(), np.arange(2.0 * c)
    given[[3, c + 3]] = 0
    m = read(write(tmp_path / "p.csv", p, forces=given, errors=bars)[0])
    assert np.array_equal(m.uncertainty.normal_forces, np.delete(bars[:c], 3))


def test_vtk_says_what_is_there(tmp_path):
    p = made(boundary="box")
    path = write(tmp_path / "p.vtk", p, errors=np.ones(2 * len(p.pairs)))[0]
    words = path.read_text().split()
    N, c = len(p.radii), len(p.pairs)
    walls = int((p.pairs[:, 1] >= N).sum())
    assert words[words.index("POINTS") + 1] == str(N + walls)
    assert words[words.index("LINES") + 1] == str(c)
    at = words.index("f_n") + 5
    assert np.array_equal(
        np.array(words[at : at + N + c], float), [*np.zeros(N), *p.normal_forces]
    )
    assert path.read_text().count("_error") == 2


def test_paraview_reads_it(tmp_path):
    """By the library that ParaView is made of, where it is installed."""
    legacy = pytest.importorskip("vtkmodules.vtkIOLegacy", reason="VTK is not installed")
    p = made()
    reader = legacy.vtkPolyDataReader()
    reader.SetFileName(str(write(tmp_path / "p.vtk", p)[0]))
    reader.ReadAllScalarsOn()
    reader.Update()
    mesh = reader.GetOutput()
    assert (mesh.GetNumberOfVerts(), mesh.GetNumberOfLines()) == (len(p.radii), len(p.pairs))
    assert mesh.GetCellData().GetArray("f_n").GetRange()[1] == p.normal_forces.max()


def test_a_measurement_has_no_npz(tmp_path):
    m = Measurement([[0, 0], [1, 0]], uncertainty=Uncertainty(positions=0.1))
    with pytest.raises(ValueError, match="npz needs: write csv"):
        write(tmp_path / "m.npz", m)
    assert [path.name for path in write(tmp_path / "m.csv", m)] == ["m.grains.csv"]


@pytest.mark.parametrize(
    ("name", "options", "what"),
    [
        ("p.txt", {}, "path = .*p.txt' ends in none of .npz, .csv, .data, .vtk"),
        ("p.txt", {"format": "xml"}, "format = 'xml' is unknown"),
        ("p.npz", {"forces": [1.0]}, "forces: the format npz holds"),
        ("p.csv", {"forces": [1.0]}, "forces: 1 forces for"),
        ("p.csv", {"errors": [[1.0]]}, "errors: forces has shape"),
    ],
)
def test_wrong_arguments(name, options, what, tmp_path):
    with pytest.raises(ValueError, match=what):
        write(tmp_path / name, made(), **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("scene", "change", "what"),
    [
        ({"boundary": Strip("rough")}, {}, "walls.glued"),
        ({}, {"external": 1e-9 * np.eye(30, 3)}, "external.* no weight"),
        ({}, {"cell": "turned"}, "cell = .* first lattice vector along x"),
    ],
)
def test_what_lammps_cannot_be_given(scene, change, what, tmp_path):
    p = made(**scene)
    if change.get("cell") == "turned":
        turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
        change = {"cell": p.cell @ turn, "positions": p.positions @ turn}
    with pytest.raises(ValueError, match=what):
        write(tmp_path / "p.data", replace(p, **change))
    assert list(tmp_path.iterdir()) == []


def test_every_format_is_written(tmp_path):
    for name, ending in FORMATS.items():
        for path in write(tmp_path / f"p{ending}", made(), format=name):
            assert path.stat().st_size > 500
