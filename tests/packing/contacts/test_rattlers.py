"""Rattlers are taken off one after another, and none that something else holds."""

from __future__ import annotations

import numpy as np

from packing.contacts.rattlers import backbone, fewest_contacts


def test_backbone_takes_rattlers_off_one_after_another():
    """A chain 3-4-5 hangs on the triangle 0-1-2: 5 has one contact, then 4, then 3."""
    pairs = np.array([[0, 1], [1, 2], [0, 2], [2, 3], [3, 4], [4, 5]])
    kept = backbone(pairs, np.ones(6, bool), 6, 2)
    assert kept.tolist() == [True] * 3 + [False] * 3
    assert not backbone(pairs, np.ones(6, bool), 6, 3).any()
    assert fewest_contacts(frictional=True) == 2
    assert fewest_contacts(frictional=False) == 3


def test_what_a_load_holds_is_no_rattler():
    """The same chain, its end 5 held from outside: all of it stays; 4 held as well changes
    nothing, and 3 alone keeps what joins it to the triangle."""
    pairs = np.array([[0, 1], [1, 2], [0, 2], [2, 3], [3, 4], [4, 5]])

    def kept(*held: int) -> list[bool]:
        return backbone(pairs, np.ones(6, bool), 6, 2, np.isin(np.arange(6), held)).tolist()

    assert kept(5) == kept(4, 5) == [True] * 6
    assert kept(3) == [True] * 4 + [False] * 2


def test_contacts_that_bear_nothing_hold_nobody():
    pairs = np.array([[0, 1], [1, 2], [0, 2]])
    bearing = np.array([True, True, False])
    assert not backbone(pairs, bearing, 3, 2).any()
    assert bearing.tolist() == [True, True, False]
