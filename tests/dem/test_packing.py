"""The record and its file: what is refused, and what comes back."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from dem import Packing
from dem.packing_file import write_record
from tests.conftest import packing


def test_saved_packing_comes_back_bit_for_bit(tmp_path):
    p = packing()
    p.save(tmp_path / "new folder" / "p.npz")
    q = Packing.load(tmp_path / "new folder" / "p.npz")
    for f in fields(Packing):
        assert np.array_equal(getattr(p, f.name), getattr(q, f.name)), f.name
    assert [f.name for f in (tmp_path / "new folder").iterdir()] == ["p.npz"]


def test_open_packing_comes_back_without_a_cell(tmp_path):
    p = column()
    p.save(tmp_path / "p.npz")
    assert Packing.load(tmp_path / "p.npz").cell is None


def column(squeeze: float = 1e-3) -> Packing:
    """Three disks in a row, pressed together by outside forces of one overlap each."""
    x = np.column_stack([(1 - squeeze) * np.arange(3.0), np.zeros(3)])
    load = np.zeros((3, 3))
    load[0, 0], load[2, 0] = squeeze, -squeeze
    return Packing(
        x, np.full(3, 0.5), None, np.array([[0, 1], [1, 2]]), np.zeros((2, 2)),
        np.full(2, squeeze), np.zeros(2), load, 1.0, squeeze, 0.3,
    )  # fmt: skip


def test_hand_made_column_is_a_packing():
    assert column().residuals() == pytest.approx(np.zeros(3), abs=1e-12)
    assert column().coordination == pytest.approx(4 / 3)


def test_record_is_frozen_through_and_through():
    with pytest.raises(ValueError, match="read-only"):
        packing().positions[0, 0] = 1.0


def changed(name: str, index: object, value: float) -> dict[str, np.ndarray]:
    array = getattr(packing(), name).copy()
    array[index] = value
    return {name: array}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda p: changed("positions", (3, 0), np.nan), r"positions\[3, 0\] is nan"),
        (lambda p: changed("radii", 2, -0.4), "grain 2 has radius -0.4"),
        (
            lambda p: changed("pairs", (0, 1), 99),
            "contact 0 names grain 99, but they are 0 ... 47",
        ),
        (lambda p: {"positions": p.positions[:-1]}, r"positions has shape \(47, 2\)"),
        (lambda p: {"cell": np.array([[1.0, 2.0], [2.0, 4.0]])}, "is singular"),
        (lambda p: {"stiffness": 0.0}, "stiffness = 0.0"),
        (lambda p: {"pressure": np.nan}, "pressure = nan"),
        (lambda p: {"friction": -1.0}, "friction = -1.0"),
        (lambda p: {"radii": p.radii * 0.99}, r"contact \d+ \(\d+, \d+\) does not touch: .* open"),
        (
            lambda p: {"normal_forces": p.normal_forces * np.linspace(1, 2, len(p.pairs))},
            r"the forces on grain \d+ do not balance: residual",
        ),
        (lambda p: {"tangential_forces": -p.tangential_forces}, "do not balance"),
        (
            lambda p: {
                "normal_forces": 2 * p.normal_forces,
                "tangential_forces": 2 * p.tangential_forces,
            },
            "carry a pressure of 0.002, not the 0.001",
        ),
        (lambda p: {"normal_forces": -p.normal_forces}, r"contact \d+ pulls: f_n = -"),
        (lambda p: {"friction": 1e-3}, r"contact \d+ exceeds the Coulomb cap of friction 0.001"),
        (lambda p: {"friction": 0.0}, "exceeds the Coulomb cap of friction 0:"),
        (lambda p: {"pairs": p.pairs + 0.5}, r"pairs\[0, 0\] is 0.5, no whole number"),
        (lambda p: changed("pairs", (0, 0), -1), "contact 0 names grain -1"),
        (lambda p: {"pairs": p.pairs[:, ::-1]}, r"contact 0 is \(\d+, 0\): write i < j"),
        (lambda p: changed("pairs", (0,), 3) | {"images": 0 * p.images}, r"contact 0 is \(3, 3\)"),
        (
            lambda p: {
                n: np.concatenate([getattr(p, n), getattr(p, n)[:1]])
                for n in ("pairs", "images", "normal_forces", "tangential_forces")
            },
            r"contact \d+ \[0, \d+, -?\d+, -?\d+\] is a duplicate",
        ),
        (lambda p: {"cell": None}, r"contact \d+ has image \[.*\] but there is no cell"),
        (
            lambda p: {"radii": p.radii * (1 - 2 * p.overlaps.max() - 1e-8)},
            "does not touch: it is open by",
        ),
    ],
)
def test_bad_packing(change, message):
    p = packing()
    with pytest.raises(ValueError, match=message):
        replace(p, **change(p))


@pytest.mark.parametrize("name", ["positions", "radii", "cell"])
def test_low_parts_are_low(name):
    """At most an ulp of what they complete: more would be another packing."""
    p = packing()
    high = getattr(p, name)
    with pytest.raises(ValueError, match=rf"{name}_low\[0.*\] is .*, more than an ulp of its"):
        replace(p, **{f"{name}_low": 1e-12 * high})
    ulp = np.where(high != 0, 0.5 * np.spacing(np.abs(high)), 0.0)
    assert replace(p, **{f"{name}_low": -ulp}).overlaps == pytest.approx(p.overlaps, abs=1e-13)


def lattice(images: list[list[int]]) -> Packing:
    """One grain in a square cell that touches itself through these faces."""
    side, count = 0.999, len(images)
    pressure = 0.001 * count * side / (2 * side**2)
    return Packing(
        np.zeros((1, 2)), np.array([0.5]), side * np.eye(2), np.zeros((count, 2), int), images,
        np.full(count, 0.001), np.zeros(count), np.zeros((1, 3)), 1.0, pressure, 0.3,
    )  # fmt: skip


@pytest.mark.parametrize("images", [[[1, 0], [0, 1]], [[-1, 0], [0, 1]], [[1, 0], [0, -1]]])
def test_a_grain_may_touch_itself(images):
    assert lattice(images).coordination == 4


@pytest.mark.parametrize("images", [[[1, 0], [-1, 0]], [[0, 1], [0, -1]], [[-1, 2], [1, -2]]])
def test_a_contact_seen_from_both_ends_is_one(images):
    with pytest.raises(ValueError, match="is a duplicate"):
        lattice(images)


def test_open_packing_has_no_width():
    with pytest.raises(ValueError, match="an open packing has no cell"):
        _ = column().width


@pytest.mark.parametrize("name", ["stiffness", "pressure", "friction"])
@pytest.mark.parametrize("value", ["1", None, True])
def test_numbers_of_a_packing_are_numbers(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r} is not a number"):
        replace(packing(), **{name: value})


@pytest.mark.parametrize("seed", range(4))
def test_any_damage_is_a_value_error_that_names_the_file(tmp_path, seed):
    """Bytes changed or cut at random, a hundred times: the packing as it was, or a ValueError."""
    path, rng = tmp_path / "p.npz", np.random.default_rng(seed)
    column().save(path)
    whole = path.read_bytes()
    for _ in range(100):
        data = bytearray(whole)
        for at in rng.integers(0, len(data), rng.integers(1, 4)):
            data[at] = rng.integers(0, 256)
        path.write_bytes(
            data[: rng.integers(len(data) // 2, len(data) + 1)] if seed == 0 else data
        )
        said = "p.npz"
        try:
            Packing.load(path)
        except ValueError as error:
            said = str(error)
        assert "p.npz" in said


@pytest.mark.parametrize(("at", "value"), [(8, 99), (6, 1)])
def test_unknown_compression_and_encryption_are_damage(tmp_path, at, value):
    """Two fields of the zip directory for which zipfile has NotImplementedError, RuntimeError."""
    path = tmp_path / "p.npz"
    column().save(path)
    data = bytearray(path.read_bytes())
    data[data.index(b"PK\x01\x02") + at + 2] = value
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"p\.npz is cut off, or not a packing"):
        Packing.load(path)


def test_info_that_is_no_object_is_refused(tmp_path):
    path = tmp_path / "p.npz"
    arrays = {f.name: getattr(column(), f.name) for f in fields(Packing) if f.name != "info"}
    for info, kind in (([1], "list"), (None, "NoneType"), ("x", "str")):
        write_record(path, {k: v for k, v in arrays.items() if v is not None}, info)
        with pytest.raises(ValueError, match=rf"p\.npz .* its info is a {kind}"):
            Packing.load(path)


def test_info_is_a_dictionary():
    with pytest.raises(ValueError, match=r"info = \[1\] is no dictionary"):
        replace(column(), info=[1])


def test_no_file_is_no_damage(tmp_path):
    with pytest.raises(FileNotFoundError):
        Packing.load(tmp_path / "p.npz")


def test_parts_of_one_process_do_not_meet(tmp_path, monkeypatch):
    """Same target and process number, as on two machines with one folder: two names."""
    parts = []
    monkeypatch.setattr(
        "dem.packing_file._write", lambda part, *a: parts.append(part) or part.touch()
    )
    for _ in range(2):
        column().save(tmp_path / "p.npz")
    assert len(set(parts)) == 2


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_file_cut_off_is_refused(tmp_path, share):
    whole, part = tmp_path / "whole.npz", tmp_path / "part.npz"
    packing().save(whole)
    data = whole.read_bytes()
    part.write_bytes(data[: int(share * len(data))])
    with pytest.raises(ValueError, match=r"part\.npz is cut off"):
        Packing.load(part)


def test_flipped_byte_is_refused(tmp_path):
    path = tmp_path / "p.npz"
    packing().save(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"p\.npz"):
        Packing.load(path)


def test_foreign_and_newer_files_are_refused(tmp_path):
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ValueError, match=r"other\.npz is an npz, but not of a packing"):
        Packing.load(tmp_path / "other.npz")
    np.savez(tmp_path / "newer.npz", format=99)
    with pytest.raises(ValueError, match="has format 99; 1 and 2 are those known"):
        Packing.load(tmp_path / "newer.npz")
    np.savez(tmp_path / "bare.npz", format=1)
    with pytest.raises(ValueError, match="not a whole packing: stiffness is missing"):
        Packing.load(tmp_path / "bare.npz")
    (tmp_path / "text.npz").write_text("x y r\n")
    with pytest.raises(ValueError, match=r"text\.npz is cut off, or not a packing"):
        Packing.load(tmp_path / "text.npz")
    np.savez(tmp_path / "pickle.npz", format=1, x=np.array([{}], dtype=object))
    with pytest.raises(ValueError, match=r"pickle\.npz"):
        Packing.load(tmp_path / "pickle.npz")
    with pytest.raises(FileNotFoundError):
        Packing.load(tmp_path / "none.npz")
