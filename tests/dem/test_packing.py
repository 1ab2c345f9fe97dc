"""The record and its file: what is refused, and what comes back."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from dem import Packing
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
