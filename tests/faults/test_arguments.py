"""Arguments in the wrong place, unit or kind."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    amplification,
    infer_contacts,
    perturb,
    reconstruct,
    rounded,
    tiled,
)
from scaling.symbolic.numeric import lambdify


def test_contacts_do_not_depend_on_the_origin():
    """The same packing moved as a whole, and with it the side of the cell that contacts cross."""
    x = np.array([[0.01, 0], [0.99, 0]])
    seen = set()
    for shift in (0.0, 0.3, 0.6, 0.98):
        moved = x + np.array([shift, 0])
        found = infer_contacts(moved, [0.26, 0.26], 0.5, cell=np.diag([1.0, 5.0]))
        seen.add(len(found[0]))
    assert seen == {4}


def test_a_threshold_in_wrong_units_is_refused_before_pairs_are_listed():
    """1000 diameters: 25 N² pairs would take 1.8 GB."""
    x = np.random.default_rng(0).uniform(0, 30, (1000, 2))
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="threshold = 1000"):
            infer_contacts(x, [0.5] * 1000, 1000.0, cell=np.eye(2) * 30)
        assert tracemalloc.get_traced_memory()[1] < 0.5e9
    finally:
        tracemalloc.stop()


def test_the_slope_of_a_linear_law_is_an_array():
    """Sympy's numerical functions return bare constants."""
    assert np.shape(lambdify.law(1)[1](np.array([0.5, 1.0, 2.0]))) == (3,)


NETWORK = ContactNetwork(
    [[0, 0], [1, 0], [0.5, 0.9]], [0.52] * 3, [[0, 1], [0, 2], [1, 2]], cell=np.eye(2) * 9
)
RNG = np.random.default_rng(0)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("stiffness", lambda: reconstruct(NETWORK, "1")),
        ("pressure", lambda: amplification(NETWORK, forces=np.ones(6), pressure=None)),
        ("xi", lambda: perturb(NETWORK, "0.1", RNG)),
        ("digits", lambda: rounded(NETWORK, "3")),
        ("copies", lambda: tiled(NETWORK, None)),
        ("threshold", lambda: infer_contacts(NETWORK.positions, NETWORK.radii, None)),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_numbers_of_the_wrong_kind_are_named(name, call):
    """Text for a number, or nothing: the message says which argument it is."""
    with pytest.raises(ValueError, match=name):
        call()
