"""Contact laws: force and overlap are inverse, slopes are derivatives, numbers become laws."""

from __future__ import annotations

import numpy as np
import pytest

from packing.contact_law import Linear, PerContact, law_of

LAWS = {"linear": Linear(3.0), "per contact": PerContact(np.array([1.0, 2.0, 5.0]))}
OVERLAPS = np.array([0.1, 1e-3, -1e-6])


@pytest.mark.parametrize("name", LAWS)
def test_overlap_is_the_inverse_and_slope_the_derivative(name):
    law, h = LAWS[name], 1e-7
    np.testing.assert_allclose(law.overlap(law.force(OVERLAPS)), OVERLAPS, rtol=1e-15)
    np.testing.assert_array_equal(law.force(-OVERLAPS), -law.force(OVERLAPS))
    difference = (law.force(OVERLAPS + h) - law.force(OVERLAPS - h)) / (2 * h)
    np.testing.assert_allclose(law.slope(OVERLAPS), difference, rtol=1e-8)
    assert (law.tangential_stiffness(OVERLAPS) == 0.5 * law.slope(OVERLAPS)).all()


def test_delta():
    assert Linear(4.0).delta(1.0) == 0.25
    assert PerContact([1.0, 2.0]).delta(1.0) == 0.75


def test_what_stands_for_a_law():
    assert law_of(2) == Linear(2.0)
    assert law_of(np.float64(2.0)) == Linear(2.0)
    assert law_of([1.0, 2.0]).stiffness.tolist() == [1.0, 2.0]
    assert law_of(LAWS["linear"]) is LAWS["linear"]


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        (0.0, r"stiffness = 0\.0"),
        (None, "stiffness = None"),
        ("1", "stiffness = '1'"),
        ([], "stiffness is empty"),
        ([1.0, -2.0], r"stiffness\[1\] \(contact 1\) is -2\.0"),
        ([1.0, np.nan], r"stiffness\[1\]"),
    ],
)
def test_what_is_no_law_is_refused(stiffness, message):
    with pytest.raises(ValueError, match=message):
        law_of(stiffness)
