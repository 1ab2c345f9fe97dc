"""The file of a packing: what comes back, and what is refused by the name of the file."""

from __future__ import annotations

import errno
import os
import stat
import tracemalloc
import warnings
import zipfile
from dataclasses import fields
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from dem import Packing
from packing.files.archive import read_arrays, write_arrays
from packing.files.npz import FORMAT, checksum, write_record
from tests.conftest import packing
from tests.fuzz.files import same
from tests.packing.test_record import column

DATA = Path(__file__).resolve().parents[2] / "data"


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
    arrays = {f.name: getattr(column(), f.name) for f in fields(Packing) if f.name != "provenance"}
    for info, kind in (([1], "list"), (None, "NoneType"), ("x", "str")):
        write_record(path, {k: v for k, v in arrays.items() if v is not None}, info)
        with pytest.raises(ValueError, match=rf"p\.npz .* its info is a {kind}"):
            Packing.load(path)


def test_no_file_is_no_damage(tmp_path):
    with pytest.raises(FileNotFoundError):
        Packing.load(tmp_path / "p.npz")


def test_parts_of_one_process_do_not_meet(tmp_path, monkeypatch):
    """Same target and process number, as of two threads: two names."""
    parts = []
    monkeypatch.setattr(
        "packing.files.npz.write_to", lambda stream, *a: parts.append(Path(stream.name).name)
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
    data[data.index(b"positions.npy") + 200] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"p\.npz"):
        Packing.load(path)


def test_foreign_and_newer_files_are_refused(tmp_path):
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ValueError, match=r"other\.npz is an npz, but not of a packing"):
        Packing.load(tmp_path / "other.npz")
    np.savez(tmp_path / "newer.npz", format=99)
    with pytest.raises(ValueError, match="has format 99; 1, 2, 3 and 4 are those known"):
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


@pytest.mark.parametrize(
    ("number", "delta", "overlaps", "forces"),
    [
        (1, 1e-3, "0x1.2be5cddfaebe0p-6", "0x1.2be5cddfae8eep-6"),
        (2, 1e-8, "0x1.920e5d04ea070p-23", "0x1.920e5d04ea070p-23"),
        (3, 2e-3, "0x1.32da721f6bb50p-5", "0x1.32da721f6bb61p-5"),
    ],
)
def test_files_of_earlier_formats_load(number, delta, overlaps, forces):
    """Packings of ten grains, written by the code of their time; the third is ramped."""
    p = Packing.load(DATA / f"packing_format_{number}.npz")
    assert len(p.pairs) == 16
    assert (p.provenance.seed, p.provenance.scene["delta"], p.delta) == (1, delta, delta)
    assert p.stiffness_ratio == 0.5
    assert p.provenance.ramp == ({"from": 1e-3} if number == 3 else None)
    assert p.provenance.notes == {}
    assert (p.positions_low is not None) == (number == 2)
    eps = np.finfo(float).eps  # of the sums, whose order is NumPy's
    assert p.overlaps.sum() == pytest.approx(float.fromhex(overlaps), rel=16 * eps)
    assert p.forces.sum() == pytest.approx(float.fromhex(forces), rel=64 * eps)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_earlier_formats_are_written_as_the_present_one(tmp_path, number):
    p = Packing.load(DATA / f"packing_format_{number}.npz")
    p.save(tmp_path / "p.npz")
    assert read(tmp_path / "p.npz")["format"] == FORMAT == 4
    assert same(p, Packing.load(tmp_path / "p.npz"))


def test_the_same_packing_gives_the_same_bytes(tmp_path):
    for name in ("one", "two"):
        packing().save(tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_notes_that_were_no_json_become_none(tmp_path):
    """Format 1 let NaN into info."""
    arrays = read(DATA / "packing_format_1.npz") | {"info": np.array('{"x": NaN, "y": [1.0]}')}
    write(tmp_path / "p.npz", arrays)
    assert Packing.load(tmp_path / "p.npz").info == {"x": None, "y": [1.0]}


def test_the_stiffness_ratio_of_earlier_formats_is_looked_for(tmp_path):
    """Of the scene, else alone; what is no positive number is not known."""
    arrays = read(DATA / "packing_format_1.npz")
    for info, ratio in (
        ('{"scene": {"stiffness_ratio": 0.25}}', 0.25),
        ('{"stiffness_ratio": 0.75}', 0.75),
        ('{"stiffness_ratio": "soft", "scene": []}', None),
        ('{"stiffness_ratio": true}', None),
        ('{"stiffness_ratio": -1}', None),
        ("{}", None),
    ):
        write(tmp_path / "p.npz", arrays | {"info": np.array(info)})
        assert Packing.load(tmp_path / "p.npz").stiffness_ratio == ratio


def read(path: Path) -> dict[str, np.ndarray]:
    with path.open("rb") as stream:
        return read_arrays(stream)


def write(path: Path, arrays: dict[str, np.ndarray]) -> None:
    with path.open("wb") as stream:
        write_arrays(stream, arrays)


def signed(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """With the list and checksum that fit, as somebody who wants to be believed would write."""
    arrays = {n: np.asarray(a) for n, a in arrays.items() if n not in ("arrays", "sha256")}
    arrays["arrays"] = np.asarray(sorted([*arrays, "arrays"]))
    return arrays | {"sha256": np.asarray(checksum(arrays))}


def saved(tmp_path: Path, p: Packing | None = None) -> Path:
    path = tmp_path / "p.npz"
    (column() if p is None else p).save(path)
    return path


def changed_by_one_ulp(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.flat[0] = np.nextafter(array.flat[0], 2)
    return array


OTHERS = ("provenance", "walls")
WRITTEN = [f.name for f in fields(Packing) if "low" not in f.name and f.name not in OTHERS]


@pytest.mark.parametrize("name", [*WRITTEN, "info"])
def test_whole_arrays_that_are_not_those_of_the_checksum(tmp_path, name):
    """Packed again with good CRCs: without the array, with another, of another type or shape."""
    path = saved(tmp_path, packing())
    arrays = read(path)
    write(path, {n: a for n, a in arrays.items() if n != name})
    with pytest.raises(ValueError, match=r"p\.npz holds .*, but lists"):
        Packing.load(path)
    others = [arrays[name][None]]
    if arrays[name].dtype.kind == "f":
        others += [changed_by_one_ulp(arrays[name]), arrays[name].astype(">f8")]
    for other in others:
        write(path, arrays | {name: other})
        with pytest.raises(ValueError, match=r"p\.npz is damaged: .* SHA-256"):
            Packing.load(path)
    write(path, arrays)  # the check passes what is as it was
    assert same(Packing.load(path), packing())


def test_big_endian_files_load(tmp_path):
    path = saved(tmp_path)
    swapped = {
        n: a.astype(a.dtype.newbyteorder(">")) if a.dtype.kind in "iuf" else a
        for n, a in read(path).items()
    }
    write(path, signed(swapped))
    assert same(Packing.load(path), column())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"extra": np.zeros(3)}, "holds extra, which no packing has"),
        ({"info": np.array("[1]")}, "its info is a list"),
        ({"info": np.array("{")}, "its info is no JSON"),
        ({"info": np.array("[" * 100_000)}, "its info is no JSON"),
        ({"info": np.array('{"x": 1' + "0" * 5000 + "}")}, "its info is no JSON"),
        ({"info": np.array('{"x": NaN}')}, r"info\['x'\] = nan"),
        ({"info": np.array('{"x": 1e999}')}, r"info\['x'\] = inf"),
        ({"info": np.array(1.0)}, "its info is a float"),
        ({"format": np.array(5)}, "has format 5; 1, 2, 3 and 4 are those known"),
        ({"format": np.array([3])}, r"has format \[3\]"),
        ({"format": np.array("3")}, "has format 3;"),
        ({"format": np.array(2)}, "holds arrays, which no packing has"),
        ({"stiffness_ratio": np.array(-1.0)}, "stiffness_ratio = -1.0"),
        (
            {"format": np.array(3), "stiffness_ratio": np.array(1.0)},
            "holds stiffness_ratio, which",
        ),
        ({"stiffness": np.array([1.0])}, "stiffness = "),
        ({"stiffness": np.array(np.nan)}, "stiffness = nan"),
        ({"pairs": np.array([[0, 1], [1, 1 << 62]])}, r"pairs\[1, 1\]"),
        ({"positions": np.full((3, 2), np.nan)}, r"positions\[0, 0\] is nan"),
    ],
)
def test_signed_nonsense_is_refused(tmp_path, change, message):
    path = saved(tmp_path)
    write(path, signed(read(path) | change))
    with pytest.raises(ValueError, match=rf"p\.npz.*{message}"):
        Packing.load(path)


def test_low_parts_and_format_agree(tmp_path):
    """A file of format 2 without low parts has lost them."""
    for number, other in ((1, 2), (2, 1)):
        arrays = read(DATA / f"packing_format_{number}.npz")
        write(tmp_path / "p.npz", arrays | {"format": np.array(other)})
        with pytest.raises(ValueError, match=rf"p\.npz .* format {other} tells of low parts"):
            Packing.load(tmp_path / "p.npz")


@pytest.mark.parametrize("number", [1, 2, 3, 4])
@pytest.mark.parametrize("where", ["before", "after", "between"])
def test_bytes_that_belong_to_no_array_are_refused(tmp_path, number, where):
    path = tmp_path / "p.npz"
    Packing.load(DATA / f"packing_format_{min(number, 3)}.npz").save(path)
    if number < 4:
        path.write_bytes((DATA / f"packing_format_{number}.npz").read_bytes())
    data = path.read_bytes()
    second = data.index(b"PK\3\4", 4)
    cut = {"before": 0, "after": len(data), "between": second}[where]
    path.write_bytes(data[:cut] + b"garbage" + data[cut:])
    with pytest.raises(ValueError, match=r"p\.npz is cut off, or not a packing"):
        Packing.load(path)


@pytest.mark.parametrize("number", [1, 2])
def test_a_swallowed_entry_is_missed_without_a_checksum(tmp_path, number):
    """One byte of the directory makes an entry the comment of the one before."""
    data = bytearray((DATA / f"packing_format_{number}.npz").read_bytes())
    starts = [at for at in range(len(data)) if data[at : at + 4] in (b"PK\1\2", b"PK\5\6")]
    for k in range(len(starts) - 2):
        bad = data.copy()
        bad[starts[k] + 32] = starts[k + 2] - starts[k + 1]
        (tmp_path / "p.npz").write_bytes(bad)
        with pytest.raises(ValueError, match=r"p\.npz .* its directory shows \d+ of \d+ arrays"):
            Packing.load(tmp_path / "p.npz")


def test_an_array_given_twice_is_refused(tmp_path):
    path = saved(tmp_path)
    with warnings.catch_warnings(), zipfile.ZipFile(path, "a") as archive:
        warnings.simplefilter("ignore")
        archive.writestr("radii.npy", archive.read("radii.npy"))
    with pytest.raises(ValueError, match=r"p\.npz .* holds an array twice"):
        Packing.load(path)


def archive_of(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return stream.getvalue()


def header(shape: str, dtype: str = "<f8") -> bytes:
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


BOMBS = {
    "64 megabytes of zeros": archive_of({"radii": header("(8388608,)") + bytes(2**26)}),
    "many arrays": archive_of({f"x{k}": header("(0,)") for k in range(2000)}),
    "shape of 1e18": archive_of({"radii": header("(1000000000000000000,)")}),
    "shape of 1e600": archive_of({"radii": header(f"({10**300}, {10**300})")}),
    "negative shape": archive_of({"radii": header("(-1, -1)") + bytes(8)}),
    "items of no size": archive_of({"radii": header("(1000000000000,)", "<U0")}),
    "records": archive_of({"radii": header("(1,)", "V1000")}),
    "objects": archive_of({"radii": header("(1,)", "|O") + bytes(8)}),
    "deep header": archive_of({"radii": header("(" * 5000 + ")" * 5000)}),
    "another compression": archive_of({"radii": header("(0,)")}, zipfile.ZIP_BZIP2),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_bombs_are_refused_in_bounded_memory(tmp_path, kind):
    path = tmp_path / "p.npz"
    path.write_bytes(BOMBS[kind])
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"p\.npz is cut off, or not a packing"):
            Packing.load(path)
        assert tracemalloc.get_traced_memory()[1] < 2**25
    finally:
        tracemalloc.stop()


def test_regular_packings_are_no_bombs(tmp_path):
    """A square lattice packs well: a long way from what is refused."""
    side, k = 40, np.arange(1600)
    right, up = (np.column_stack([k, other]) for other in ((k + 1) % 1600, (k + side) % 1600))
    right[:, 1] = np.where(k % side == side - 1, k - side + 1, k + 1)
    pairs = np.vstack([right, up])
    images = np.zeros((3200, 2), int)
    images[:1600, 0], images[1600:, 1] = k % side == side - 1, k // side == side - 1
    back = pairs[:, 0] > pairs[:, 1]
    pairs[back], images[back] = pairs[back][:, ::-1], -images[back]
    p = Packing(
        0.999 * np.column_stack([k % side, k // side]), np.full(1600, 0.5),
        0.999 * side * np.eye(2), pairs, images, np.full(3200, 0.001), np.zeros(3200),
        np.zeros((1600, 3)), 1.0, 0.001 / 0.999, 0.3,
    )  # fmt: skip
    path = saved(tmp_path, p)
    unpacked = sum(a.nbytes for a in read(path).values())
    assert unpacked < 40 * path.stat().st_size
    assert same(Packing.load(path), p)


@pytest.mark.parametrize("path", [None, 3, "", 1.5, [], {}, "a\0b", b"", "\ud800", np.nan])
def test_what_is_no_path_is_refused(path):
    for call in (Packing.load, column().save):
        with pytest.raises(ValueError, match=r"path = .* is no path of a file"):
            call(path)


def test_paths_that_can_be_no_file_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", ".", tmp_path / "file" / "p.npz", "x" * 5000):
        for call in (Packing.load, column().save):
            with pytest.raises(ValueError, match=r"path = "):
                call(path)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_long_names_and_bytes_are_paths(tmp_path):
    """250 of the 255 bytes that a name may have; the part beside it needs no more."""
    for name in ("x" * 246 + ".npz", "Δ" * 120 + ".npz", "no suffix"):
        column().save(tmp_path / name)
        assert same(Packing.load(os.fsencode(tmp_path / name)), column())
    assert len(list(tmp_path.iterdir())) == 3


def test_missing_rights_are_no_damage(tmp_path, monkeypatch):
    path = saved(tmp_path)

    def denied(*args: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(Path, "open", denied)
    for call in (Packing.load, column().save):
        with pytest.raises(PermissionError, match=r"Permission denied: .*p\.npz"):
            call(path)


def test_files_beyond_four_gigabytes_load(tmp_path, monkeypatch):
    """Their zip has offsets of eight bytes; here it has them from a kilobyte on."""
    monkeypatch.setattr(zipfile, "ZIP64_LIMIT", 1000)
    path = saved(tmp_path)
    monkeypatch.undo()
    assert b"PK\6\6" in path.read_bytes()
    assert same(Packing.load(path), column())
