"""Where a packing comes from: fields that are what they are called, and notes beside them."""

from __future__ import annotations

import numpy as np
import pytest

from packing.provenance import Provenance


@pytest.mark.parametrize(
    ("notes", "message"),
    [
        (None, "notes = None is no dictionary"),
        ("x", "notes = 'x' is no dictionary"),
        ({"x": np.nan}, r"notes\['x'\] = nan is not a finite number"),
        ({"x": {"y": [1, np.inf]}}, r"notes\['x'\]\['y'\]\[1\] = inf is not a finite number"),
        ({"x": 10**5000}, r"notes\['x'\] is a whole number of more than 4000 digits"),
        ({1: 2}, "notes has the key 1: keys are text"),
        ({"x": {None: 2}}, r"notes\['x'\] has the key None"),
        ({"x": {1, 2}}, r"notes\['x'\] = \{1, 2\} is a set"),
        ({"x": 1j}, r"notes\['x'\] = 1j is a complex"),
        ({"x": np.zeros(2)}, r"notes\['x'\] = array\(\[0., 0.\]\) is a ndarray"),
        ({"x": b"y"}, r"notes\['x'\] = b'y' is a bytes"),
        ({"x": np.timedelta64(1)}, r"notes\['x'\] = .* is a timedelta64"),
    ],
)
def test_notes_that_no_file_could_hold_are_refused(notes, message):
    with pytest.raises(ValueError, match=message):
        Provenance(notes=notes)


def test_notes_that_hold_themselves_are_refused():
    notes: dict = {}
    notes["x"] = notes
    with pytest.raises(ValueError, match="notes is nested deeper than 50 times"):
        Provenance(notes=notes)


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"seed": "1"}, "seed = '1' is no whole number"),
        ({"seed": True}, "seed = True is no whole number"),
        ({"speed": "fast"}, "speed = 'fast' is no number"),
        ({"speed": np.inf}, "speed = inf is not a finite number"),
        ({"scene": [1]}, r"scene = \[1\] is no dictionary"),
        ({"scene": {"x": 1j}}, r"scene\['x'\] = 1j is a complex"),
        ({"backend": 3}, "backend = 3 is no text"),
        ({"seed": 1, "notes": {"seed": 2}}, "notes has the key 'seed', and seed is given, too"),
    ],
)
def test_a_field_is_what_it_is_called(facts, message):
    with pytest.raises(ValueError, match=message):
        Provenance(**facts)


def test_what_is_given_is_copied_as_plain_values():
    notes = {"x": np.float32(0.5), "y": (np.int64(1), None, np.True_, "ΔΔ"), "z": {"a": [1.0]}}
    known = Provenance(seed=np.int64(3), speed=1, notes=notes)
    plain = {"seed": 3, "speed": 1, "x": 0.5, "y": [1, None, True, "ΔΔ"], "z": {"a": [1.0]}}
    assert known.plain() == plain
    notes["z"]["a"].append(2.0)
    known.plain()["z"]["a"].append(3.0)
    assert known.plain() == plain


def test_one_dictionary_and_back():
    """Fields by their names; what does not fit its field, as in files of before, is a note."""
    info = {"seed": "seven", "scene": {"delta": 1e-3}, "steps": 10, "wall": 3.0}
    known = Provenance.of_plain(info)
    assert (known.scene, known.steps, known.seed) == ({"delta": 1e-3}, 10, None)
    assert known.notes == {"seed": "seven", "wall": 3.0}
    assert known.plain() == info
    assert known.noted(seed=7, notes_of="mine").seed == 7
