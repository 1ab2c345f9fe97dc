"""What a measurement takes and refuses; notes and refusals as values."""

from __future__ import annotations

import pickle
from copy import deepcopy

import numpy as np
import pytest

from packing.boundary import Walls
from packing.diagnosis import diagnose
from packing.files.problem import FileProblem
from packing.measurement import Measurement, Uncertainty
from packing.note import Note
from packing.seen import Seen
from tests.conftest import packing

PAIR = [[0.0, 0.0], [0.99, 0.0]]


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"positions": []}, "positions has shape|positions is empty"),
        ({"positions": [[0, 0], [np.nan, 1]]}, r"positions\[1, 0\] is nan"),
        ({"radii": [0.5]}, r"radii has shape \(1,\)"),
        ({"radii": [0.5, -1]}, "radius of grain 1 is -1"),
        ({"pairs": [[0, 2]]}, "names grain 2"),
        ({"pairs": [[1, 0]]}, r"is \(1, 0\)"),
        ({"pairs": [[0, 1], [0, 1]]}, "repeats contact 0"),
        ({"pairs": [[0, 1]], "normals": [[2, 0]]}, "normal of contact 0 has length 2"),
        ({"pairs": [[0, 1]], "normal_forces": [1, 2]}, "normal_forces has shape"),
        ({"external": [[1, 2]]}, "external has shape"),
        ({"stiffness": 0}, "stiffness = 0"),
        ({"friction": -1}, "friction = -1"),
        ({"uncertainty": {"radii": 1}}, "uncertainty"),
    ],
)
def test_what_is_refused(changed, what):
    with pytest.raises(ValueError, match=what):
        Measurement(**{"positions": PAIR} | changed)


def test_arrays_stay_read_only_on_every_way():
    m = Measurement(PAIR, radii=[0.5, 0.5], uncertainty=Uncertainty(radii=np.ones(2)))
    for copy in (m, deepcopy(m), pickle.loads(pickle.dumps(m))):
        with pytest.raises(ValueError, match="read-only"):
            copy.positions[0, 0] = 1


def test_images_that_are_left_out_are_the_nearest():
    m = Measurement([[0.1, 0], [2.9, 0]], cell=np.diag([3.0, 3.0]), pairs=[[0, 1]])
    assert m.images.tolist() == [[-1, 0]]
    assert Measurement(PAIR).contacts == 0


def test_what_is_seen_is_what_a_packing_computes():
    """Overlaps, balance and virial, periodic; and of a wall contact by hand."""
    p = packing()
    seen = Seen.of(p)
    assert seen.overlaps == pytest.approx(p.overlaps, abs=1e-15)
    assert seen.virial == pytest.approx(p.pressure, rel=1e-9)
    scale = p.normal_forces.mean() / (p.pressure * 2 * p.radii.mean())
    assert seen.unbalanced * scale == pytest.approx(p.residuals(), abs=1e-12)
    on_floor = Measurement(
        [[0, 0.4]], radii=[0.5], pairs=[[0, 1]], walls=Walls([[0.0, -1.0]], [0.0]),
        normal_forces=[2.0], tangential_forces=[0.5], external=[[-0.5, -2.0, -0.25]],
    )  # fmt: skip
    seen = Seen.of(on_floor)
    assert seen.overlaps.tolist() == pytest.approx([0.1])
    assert seen.net.tolist() == [[0, 0, 0]]


def test_what_is_diagnosed_is_a_packing_or_a_measurement():
    with pytest.raises(ValueError, match=r"packing = 'p\.npz' is no Measurement"):
        diagnose("p.npz")
    found = diagnose(packing())
    assert [note.severity for note in found] == ["information"] * len(found)


def test_errors_come_first():
    found = diagnose(Measurement(PAIR, radii=[1, 1], pairs=[[0, 1]], normal_forces=[1]))
    order = [note.severity for note in found]
    assert order == sorted(order, key=["error", "warning", "information"].index)
    assert found[0].name == "diameters-for-radii"


def test_notes_and_refusals_are_values():
    note = Note("error", "cut-short", "3 of 5", "a.csv", 7, 3)
    assert Note(**note.plain()) == note
    assert pickle.loads(pickle.dumps(FileProblem(note))).note == note
    assert str(Note("warning", "pixels", "why")) == "why [pixels]"
    with pytest.raises(ValueError, match="severity = 'fatal'"):
        Note("fatal", "x", "y")
