"""Each format, on files that are written here as the other code writes them."""

from __future__ import annotations

import gzip
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from packing.contact_law import Linear
from packing.files.problem import FileProblem
from packing.measurement import Measurement
from packing.reading import FORMATS, notes, read
from packing.record import Packing
from packing.seen import Seen
from tests.packing.dumps import Dump
from tests.packing.sample_files import SAMPLES, made, rigid_library


def names(found):
    return [note.name for note in notes(found)]


def agree(p, q, tolerance=0.0):
    """The same grains and contacts, whatever their order."""
    assert np.abs(p.radii - q.radii).max() <= tolerance
    order = [np.lexsort((*k.images.T, *k.pairs.T)) for k in (p, q)]
    assert np.array_equal(p.pairs[order[0]], q.pairs[order[1]])
    for name in ("normal_forces", "tangential_forces"):
        a, b = getattr(p, name)[order[0]], getattr(q, name)[order[1]]
        assert np.abs(a - b).max() <= max(tolerance, 1e-12 * np.abs(a).max()), name


PACKINGS = {
    "npz": {},
    "csv": {},
    "walled-csv": {"boundary": "box"},
    "lammps-dump": {},
    "jambashbulk": {"friction": 0.0},
    "mercury": {"boundary": "box"},
    "rigid-library": {"grains": 40},
    "periodic-mercury": {},
}


@pytest.mark.parametrize("name", PACKINGS)
def test_a_packing_comes_back(name, tmp_path):
    path, options = SAMPLES[name](tmp_path)
    found = read(path, **options)
    assert isinstance(found, Packing), [str(note) for note in notes(found)]
    p = made(**PACKINGS[name])
    agree(p, found, 1e-8 if name == "rigid-library" else 1e-13)
    assert found.stiffness == pytest.approx(1, rel=1e-9)
    assert found.pressure == pytest.approx(
        p.pressure if p.walls is None or name == "walled-csv" else Seen.of(p).virial, rel=1e-9
    )


@pytest.mark.parametrize("name", SAMPLES)
def test_the_format_is_recognised(name, tmp_path):
    """The same with its name as without; as another one it is refused by file."""
    path, options = SAMPLES[name](tmp_path)
    own = name.removeprefix("walled-").removeprefix("periodic-")
    assert own in FORMATS
    a, b = read(path, **options), read(path, format=own, **options)
    assert np.array_equal(a.positions, b.positions)
    for other in set(FORMATS) - {own}:
        with pytest.raises(ValueError, match=f"{path.name}|option") as refused:
            read(path, format=other, **options)
        assert isinstance(refused.value, FileProblem) or "option" in str(refused.value)


@pytest.mark.parametrize("name", [n for n in SAMPLES if n not in ("npz", "pegs-mat")])
def test_text_may_be_packed_and_have_other_line_ends(name, tmp_path):
    path, options = SAMPLES[name](tmp_path)
    whole = read(path, **options)
    for file in tmp_path.iterdir():
        data = file.read_bytes()
        file.write_bytes(gzip.compress(data.replace(b"\n", b"\r\n")))
    packed = read(path, **options)
    assert np.array_equal(whole.positions, packed.positions)
    assert (whole.pairs is None) or np.array_equal(whole.pairs, packed.pairs)


@pytest.mark.parametrize("coordinates", ["x", "xu", "xs", "xsu"])
@pytest.mark.parametrize("order", [(0, 1, 2, 3, 4, 5, 6, 7), (6, 7, 2, 4, 5, 0, 1, 3)])
def test_dumps_of_any_kind(coordinates, order, tmp_path):
    """Wrapped, unwrapped, scaled; columns in any order; forces on either grain; either first."""
    p = made()
    for second in (False, True):
        for reverse in (False, True):
            how = Dump(coordinates=coordinates, order=order, second=second, reverse=reverse)
            atoms, contacts = how.write(tmp_path, p)
            found = read(atoms, contacts=contacts)
            assert isinstance(found, Packing), [str(note) for note in notes(found)]
            agree(p, found, 1e-13)
            assert any("act on the second" in n.text for n in notes(found)) == second


@pytest.mark.parametrize("second", [False, True])
def test_the_whole_force_is_known_by_its_balance(second, tmp_path):
    """One vector that is neither along the line of centres nor across it: it balances."""
    p = made()
    atoms, contacts = Dump(whole=True, second=second).write(tmp_path, p)
    found = read(atoms, contacts=contacts)
    assert isinstance(found, Packing), [str(note) for note in notes(found)]
    agree(p, found, 1e-13)
    assert any("whole force" in note.text for note in notes(found))


def test_single_numbers_are_named(tmp_path):
    """A column of f_n alone is not guessed, but it can be told."""
    p = made(friction=0.0)
    atoms, contacts = Dump(order=(0, 1, 2, 3)).write(tmp_path, p)
    assert read(atoms, contacts=contacts).normal_forces is None
    columns = {"id1": "c_pd[1]", "id2": "c_pd[2]", "fn": "c_pd[4]"}
    agree(p, read(atoms, contacts=contacts, columns=columns), 1e-13)


def test_a_pressure_that_the_forces_do_not_carry(tmp_path):
    """Δ, κ and p have to go together: the P of the header, 3 % off."""
    path, _ = SAMPLES["jambashbulk"](tmp_path)
    p = made(friction=0.0)
    path.write_text(path.read_text().replace(f"P = {p.pressure!r}", f"P = {1.03 * p.pressure!r}"))
    found = read(path)
    assert isinstance(found, Measurement)
    assert "units-mixed" in names(found)


def test_diameters_are_noticed_without_contacts(tmp_path):
    """By neighbours that reach half into each other; and told, they are halved."""
    p = made()
    path = tmp_path / "g.csv"
    rows = [
        f"{x!r},{y!r},{2 * r!r}"
        for (x, y), r in zip(p.positions.tolist(), p.radii.tolist(), strict=True)
    ]
    path.write_text("\n".join(["x,y,r", *rows]) + "\n")
    with pytest.raises(FileProblem, match="diameters-for-radii"):
        read(path)
    assert np.array_equal(read(path, sizes="diameters").radii, p.radii)
    path.write_text("\n".join(["x,y,d", *rows]) + "\n")
    assert np.array_equal(read(path).radii, p.radii)


def test_forces_act_on_the_grain_that_is_said(tmp_path):
    """Named by columns=, nothing is guessed; swapped names turn f_t round, which balance shows."""
    p = made()
    atoms, contacts = Dump().write(tmp_path, p)
    columns = {"id1": "c_pd[1]", "id2": "c_pd[2]", "normal": ("c_pd[5]", "c_pd[6]")}
    right = columns | {"tangential": ("c_pd[7]", "c_pd[8]")}
    found = read(atoms, contacts=contacts, columns=right)
    agree(p, found, 1e-13)
    assert not any("c_pd" in note.text for note in notes(found))
    wrong = columns | {"tangential": ("c_pd[8]", "c_pd[7]")}
    assert isinstance(read(atoms, contacts=contacts, columns=wrong), Measurement)


@pytest.mark.parametrize(
    ("columns", "what"),
    [
        ({"id1": "c_pd[1]"}, "id1 and id2"),
        ({"id1": "c_pd[1]", "id2": "c_pd[99]"}, r"c_pd\[99\]"),
        ({"id1": "c_pd[1]", "id2": "c_pd[2]", "normal": "c_pd[3]"}, "normal.* 2 of"),
        ({"shear": "c_pd[1]"}, "shear"),
    ],
)
def test_wrong_names_of_columns(columns, what, tmp_path):
    atoms, contacts = Dump().write(tmp_path, made())
    with pytest.raises(ValueError, match=what):
        read(atoms, contacts=contacts, columns=columns)


def test_frames(tmp_path):
    """The last is read, or the one that is asked for; contacts are those of its time step."""
    p = made()
    atoms, contacts = Dump(frames=3, coordinates="xu").write(tmp_path, p)
    agree(p, read(atoms, contacts=contacts), 1e-13)
    early = read(atoms, contacts=contacts, frame=0)
    assert early.positions == pytest.approx(1.5 * p.positions)
    assert [note.number for note in notes(early) if note.name == "frames"] == [0]
    with pytest.raises(ValueError, match=r"frame = 3, but .* has 3 frames"):
        read(atoms, contacts=contacts, frame=3)


def test_boxes_that_do_not_say_their_sides(tmp_path):
    """Those that contacts cross are periodic: both here; none, if the others are left out."""
    p = made()
    atoms, contacts = Dump().write(tmp_path, p)
    for file in (atoms, contacts):
        file.write_text(file.read_text().replace("BOUNDS pp pp pp", "BOUNDS"))
    agree(p, read(atoms, contacts=contacts), 1e-13)
    inner = ~p.images.any(axis=1)
    part = {
        k: getattr(p, k)[inner] for k in ("pairs", "images", "normal_forces", "tangential_forces")
    }
    m = Measurement(p.positions, radii=p.radii, cell=p.cell, **part)
    atoms, contacts = Dump(coordinates="xu").write(
        tmp_path,
        SimpleNamespace(
            **{k: getattr(m, k) for k in ("positions", "radii", "cell", *part)},
            branches=p.branches[inner],
        ),
    )
    for file in (atoms, contacts):
        file.write_text(file.read_text().replace("BOUNDS pp pp pp", "BOUNDS"))
    found = read(atoms, contacts=contacts)
    assert found.cell is None
    assert np.array_equal(found.pairs, m.pairs)


def test_frames_with_times_and_units(tmp_path):
    """`dump_modify time yes units yes` puts lines before each time step."""
    p = made()
    atoms, contacts = Dump(frames=3).write(tmp_path, p)
    for file in (atoms, contacts):
        text = file.read_text().replace("ITEM: TIMESTEP", "ITEM: TIME\n0.5\nITEM: TIMESTEP")
        file.write_text("ITEM: UNITS\nlj\n" + text)
    agree(p, read(atoms, contacts=contacts), 1e-13)
    assert read(atoms, contacts=contacts, frame=0).positions is not None


def test_a_table_is_told_its_cell_and_its_walls(tmp_path):
    """The facts above the names of the columns left out, and told."""
    for scene in ({}, {"boundary": "box"}):
        p = made(**scene)
        path = SAMPLES["walled-csv" if scene else "csv"](tmp_path)[0]
        rows = path.read_text().split("\n")
        path.write_text(
            "\n".join(r for r in rows if not r.startswith(("# cell", "# wall", "# load")))
        )
        told = (
            {"cell": p.cell}
            if p.walls is None
            else {"walls": np.column_stack([p.walls.normals, p.walls.offsets])}
        )
        found = read(path, **told)
        assert isinstance(found, Packing), [str(note) for note in notes(found)]
        agree(p, found)
        if p.walls is None:
            assert np.array_equal(read(path, cell=np.diag(p.cell)).cell, p.cell)
            with pytest.raises(ValueError, match="cell"):
                read(path, cell=[[1, 2], [2, 4]])
        else:
            with pytest.raises(ValueError, match="walls"):
                read(path, walls=[[0, 1]])
            with pytest.raises(FileProblem, match="missing-walls"):
                read(path)


def test_a_tilted_box(tmp_path):
    """The bounding box of a triclinic cell is larger by its tilt."""
    p = made()
    sheared = np.array([p.cell[0], p.cell[1] + np.array([2.0, 0.0])])
    x = p.positions @ np.linalg.inv(p.cell) @ sheared
    text = (
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS xy xz yz pp pp pp\n"
        "0 {high!r} 2.0\n0 {b!r} 0\n-1 1 0\nITEM: ATOMS id xs ys radius\n{rows}\n"
    )
    s = x @ np.linalg.inv(sheared)
    rows = [
        f"{k} {a!r} {b!r} {r!r}"
        for k, ((a, b), r) in enumerate(zip(s.tolist(), p.radii.tolist(), strict=True))
    ]
    file = tmp_path / "tilted.dump"
    high, b = float(p.cell[0, 0]) + 2.0, float(p.cell[1, 1])
    file.write_text(text.format(n=len(x), high=high, b=b, rows="\n".join(rows)))
    m = read(file)
    assert m.cell == pytest.approx(sheared, rel=1e-15)
    assert m.positions == pytest.approx(x, abs=1e-13)


@pytest.mark.parametrize("coordinates", ["x", "xu", "xs", "xsu"])
def test_a_packing_in_a_tilted_box(coordinates, tmp_path):
    """The same lattice by other vectors, (b + a) for b: forces and contacts are the same."""
    p = made()
    tilted = np.array([p.cell[0], p.cell[1] + p.cell[0]])
    images = np.rint(p.images @ p.cell @ np.linalg.inv(tilted)).astype(int)
    q = replace(p, cell=tilted, images=images)
    atoms, contacts = Dump(coordinates=coordinates).write(tmp_path, q)
    found = read(atoms, contacts=contacts)
    assert isinstance(found, Packing), [str(note) for note in notes(found)]
    assert found.cell == pytest.approx(tilted, rel=1e-15)
    agree(q, found, 1e-13)


def test_a_general_triclinic_box(tmp_path):
    text = (
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS abc origin pp pp pp\n"
        "3 1 0 0.5\n-1 4 0 0.25\n0 0 1 -0.5\n"
        "ITEM: ATOMS id xs ys radius\n1 0 0 0.5\n2 0.5 0.5 0.5\n"
    )
    (tmp_path / "abc.dump").write_text(text)
    m = read(tmp_path / "abc.dump")
    assert m.cell.tolist() == [[3, 1], [-1, 4]]
    assert m.positions.tolist() == [[0.5, 0.25], [1.5, 2.75]]


def test_radii_by_type(tmp_path):
    head = (
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff pp\n0 9\n0 9\n0 1\n"
    )
    (tmp_path / "t.dump").write_text(head + "ITEM: ATOMS id type x y\n2 1 3 3\n1 2 1 1\n")
    path = tmp_path / "t.dump"
    assert read(path).radii is None
    assert read(path, radius=0.5).radii.tolist() == [0.5, 0.5]
    assert read(path, radius={1: 0.5, 2: 0.7}).radii.tolist() == [0.7, 0.5]
    with pytest.raises(ValueError, match=r"radius.* no type 2"):
        read(path, radius={1: 0.5})


def test_a_sheared_cell_needs_its_strain(tmp_path):
    """The wrong Lees-Edwards shift turns the directions of contacts across the side: refused."""
    path, _ = rigid_library(tmp_path)
    assert isinstance(read(path, lees_edwards=1.0), Packing)  # a whole period
    with pytest.raises(FileProblem, match="another shear"):
        read(path, lees_edwards=0.5)


@pytest.mark.parametrize("name", ["photoelastic", "pegs-mat"])
def test_forces_from_both_sides(name, tmp_path):
    """The mean of the two readings, with its standard deviation: 0.05/√2 ⟨f_n⟩ was put in."""
    path, options = SAMPLES[name](tmp_path)
    m = read(path, **options)
    p = made(boundary="box")
    assert isinstance(m, Measurement)
    assert (m.grains, m.contacts) == (len(p.radii), len(p.pairs))
    assert {"two-sided", "pixels", "guessed"} <= set(names(m))
    inner = p.pairs[:, 1] < len(p.radii)
    true = dict(zip(map(tuple, p.pairs[inner].tolist()), p.normal_forces[inner], strict=True))
    found = zip(map(tuple, m.pairs.tolist()), m.normal_forces, strict=True)
    ours = {pair: f for pair, f in found if pair[1] < m.grains}
    assert set(ours) == set(true)
    off = np.array([ours[k] - true[k] for k in true]) / p.normal_forces.mean()
    noise = 0.05 / np.sqrt(2)
    # A standard deviation of so many numbers is known to 1/√(2c); three of these.
    band = 1 + 3 / np.sqrt(2 * len(off)) * np.array([-1, 1])
    assert band[0] < np.std(off) / noise < band[1]
    told = m.uncertainty.normal_forces / p.normal_forces.mean()
    assert band[0] < told / noise < band[1]
    # Walls are the sides of the box, to the rounding of pixels.
    assert np.sort(m.walls.offsets) / 60 == pytest.approx(np.sort(p.walls.offsets), abs=0.05)


def test_metres_for_pixels(tmp_path):
    path, options = SAMPLES["photoelastic"](tmp_path)
    pixels, metres = read(path, **options), read(path, metre_per_pixel=1e-4, **options)
    assert metres.positions == pytest.approx(1e-4 * pixels.positions)
    assert (pixels.length_unit, metres.length_unit) == ("px", "m")
    assert "pixels" not in names(metres)


def test_grains_of_an_image_without_contacts(tmp_path):
    """They are a measurement in pixels, or in metres; a pixel of no size is refused."""
    path, options = SAMPLES["photoelastic"](tmp_path)
    options["contacts"].unlink()
    pixels, metres = read(path), read(path, metre_per_pixel=1e-4)
    assert metres.positions == pytest.approx(1e-4 * pixels.positions)
    assert (metres.length_unit, metres.pairs) == ("m", None)
    with pytest.raises(ValueError, match="metre_per_pixel = 0"):
        read(path, metre_per_pixel=0)


def test_a_reading_that_measured_nothing(tmp_path):
    """Tangential readings that are not correlated are dropped, and this is said."""
    path, options = SAMPLES["photoelastic"](tmp_path)
    rows = [row.split(",") for row in options["contacts"].read_text().split()]
    noise = np.random.default_rng(1).normal(size=len(rows))
    options["contacts"].write_text(
        "".join(
            f"{r[0]},{r[1]},{r[2]},{x!r},{r[4]}\n"
            for r, x in zip(rows, noise.tolist(), strict=True)
        )
    )
    m = read(path, **options)
    assert m.tangential_forces is None
    assert "f_t counts as not measured" in next(n.text for n in m.notes if n.name == "two-sided")


def test_spheres_of_yade(tmp_path):
    """Without their walls they are a measurement; f_t and f_n have their signs."""
    path, options = SAMPLES["yade"](tmp_path)
    m, p = read(path, **options), made(boundary="box")
    inner = p.pairs[:, 1] < len(p.radii)
    assert np.array_equal(m.pairs, p.pairs[inner])
    assert m.normal_forces == pytest.approx(p.normal_forces[inner], rel=1e-12)
    assert m.tangential_forces == pytest.approx(p.tangential_forces[inner], abs=1e-15)
    assert isinstance(m.law, Linear)
    assert "missing-walls" in names(m)


def test_matlab_7_3_is_refused_by_name(tmp_path):
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan 01 00:00:00 2024 HDF5"
    (tmp_path / "a.mat").write_bytes(head.ljust(512) + b"\x89HDF\r\n\x1a\n")
    with pytest.raises(FileProblem, match=r"a.mat: .*7\.3.*-v7"):
        read(tmp_path / "a.mat")


def test_weight_is_found_or_told(tmp_path):
    """A packing under weight, its loads left out of the table."""
    p = made(boundary="walls", gravity=1e-4)
    path = SAMPLES["csv"].__globals__["write"](tmp_path / "g.csv", p)[0]
    table = path.read_text()
    lines = [
        row if row.startswith("#") else ",".join(row.split(",")[:4]) for row in table.split("\n")
    ]
    path.write_text("\n".join(lines))
    guessed, told = read(path), read(path, gravity=1e-4)
    assert isinstance(guessed, Packing)
    assert isinstance(told, Packing)
    assert guessed.external == pytest.approx(p.external, abs=1e-12)
    assert told.external == pytest.approx(p.external, abs=1e-12)
    assert any("weight of the grains" in note.text for note in notes(guessed))
    assert isinstance(read(path, gravity=(1e-4, 0)), Measurement)


def test_options_are_those_of_the_format(tmp_path):
    path, _ = SAMPLES["jambashbulk"](tmp_path)
    with pytest.raises(ValueError, match="columns is no option of the format jambashbulk"):
        read(path, columns={})
    with pytest.raises(ValueError, match="format = 'dump' is unknown"):
        read(path, format="dump")
    for wrong in (
        {"stiffness": -1},
        {"law": "cubic"},
        {"uncertainty": {"sizes": 1}},
        {"frame": 5},
    ):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            read(path, **wrong)


def test_uncertainty_and_units_are_told(tmp_path):
    path, options = SAMPLES["yade"](tmp_path)
    m = read(path, uncertainty={"positions": 1e-3}, length_unit="mm", force_unit="N", **options)
    assert (m.uncertainty.positions, m.length_unit, m.force_unit) == (1e-3, "mm", "N")


def test_a_missing_file_stays_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="is no file"):
        read(tmp_path)


def test_springs_that_a_table_names_without_their_stiffness_are_told_it(tmp_path):
    """κ that is told makes the law; control: without it there is none, and no other is refused."""
    grains, contacts = tmp_path / "g.csv", tmp_path / "c.csv"
    grains.write_text("# law: linear\nx,y,r\n0,0,0.5\n0.99,0,0.5\n1.98,0,0.5\n")
    contacts.write_text("i,j\n0,1\n1,2\n")
    told = read(grains, contacts=contacts, stiffness=2.0)
    assert told.law == Linear(2.0, 0.5)
    assert read(grains, contacts=contacts).law is None
    grains.write_text(grains.read_text().replace("linear", "springs"))
    with pytest.raises(FileProblem, match="neither 'linear' nor"):
        read(grains, contacts=contacts)
