"""The record of a packing at rest: what is refused, and what is kept."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from dem import Packing
from packing.provenance import Provenance
from tests.conftest import packing


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
            "contact 0 names grain 99, but the grains are 0 ... 47",
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
        (lambda p: {"pairs": p.pairs[:, ::-1]}, r"contact 0 is \(\d+, 0\): contacts are ordered"),
        (
            lambda p: changed("pairs", (0,), 3) | {"images": 0 * p.images},
            "contact 0 joins grain 3 to itself",
        ),
        (
            lambda p: {
                n: np.concatenate([getattr(p, n), getattr(p, n)[:1]])
                for n in ("pairs", "images", "normal_forces", "tangential_forces")
            },
            r"contact \d+ repeats contact \d+: grains \(0, \d+\), image",
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
    with pytest.raises(ValueError, match="repeats contact"):
        lattice(images)


def test_open_packing_has_no_width():
    with pytest.raises(ValueError, match="an open packing has no cell"):
        _ = column().width


@pytest.mark.parametrize("name", ["stiffness", "pressure", "friction"])
@pytest.mark.parametrize("value", ["1", None, True])
def test_numbers_of_a_packing_are_numbers(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r} is not a number"):
        replace(packing(), **{name: value})


def test_provenance_is_a_provenance():
    with pytest.raises(ValueError, match=r"provenance = \{\} is no Provenance"):
        replace(column(), provenance={})


@pytest.mark.parametrize("ratio", [0, -1.0, "1", np.nan])
def test_a_stiffness_ratio_is_positive_or_unknown(ratio):
    assert column().stiffness_ratio is None
    with pytest.raises(ValueError, match="stiffness_ratio = "):
        replace(column(), stiffness_ratio=ratio)


#: What no argument of a packing is; for numbers and arrays alike.
ODD = [
    None, "1", 1j, np.nan, np.inf, 1e300, [], [[1.0, 2.0], [3.0]], {}, object(), b"1", True,
    np.datetime64("2020-01-01"), np.array([1.0, None]), np.array(["1"]), np.array([1j]),
    np.ma.masked, np.array([True]), np.array(np.nan), [np.ma.masked], -np.inf, 10**400,
]  # fmt: skip
ARRAYS = (
    "positions", "radii", "cell", "pairs", "images", "normal_forces", "tangential_forces",
    "external", "positions_low", "radii_low", "cell_low",
)  # fmt: skip
#: None stands for no cell, or no low parts; a number is no array of one.
MAY_BE_NONE = ("cell", "positions_low", "radii_low", "cell_low")


@pytest.mark.parametrize("name", ARRAYS)
def test_odd_arrays_are_refused_by_name(name):
    for odd in ODD:
        if odd is None and name in MAY_BE_NONE:
            continue
        # Without pairs it is the images that are too many.
        with pytest.raises(ValueError, match="pairs|images" if name == "pairs" else name):
            replace(column_in_a_cell(), **{name: odd})


@pytest.mark.parametrize("name", ARRAYS)
def test_odd_entries_are_refused_by_name(name):
    """One entry masked, NaN, infinite, too large to be squared; types that hold no numbers."""
    p = column_in_a_cell()
    high = np.array(getattr(p, name.removesuffix("_low")))
    array = 0.0 * high if name.endswith("_low") else high.astype(float)
    assert isinstance(replace(p, **{name: array}), Packing)
    masked = np.ma.masked_array(array, mask=np.arange(array.size).reshape(array.shape) == 1)
    wrong = [masked, array.astype(complex), array.astype(object), array.astype(str)]
    wrong += [array.astype("datetime64[s]"), array.astype(bool), array[..., None]]
    for value in (np.nan, np.inf, 1e200, -1e300):
        wrong.append(array.copy())
        wrong[-1].flat[-1] = value
    for odd in wrong:
        with pytest.raises(ValueError, match=rf"\b{name}"):
            replace(p, **{name: odd})


def column_in_a_cell() -> Packing:
    """Three disks in a periodic row."""
    side = 3 * 0.999
    return Packing(
        np.column_stack([0.999 * np.arange(3.0), np.zeros(3)]), np.full(3, 0.5),
        np.array([[side, 0.0], [0.0, 5.0]]), [[0, 1], [1, 2], [0, 2]],
        [[0, 0], [0, 0], [-1, 0]], np.full(3, 0.001), np.zeros(3), np.zeros((3, 3)), 1.0,
        3 * 0.001 * 0.999 / (2 * side * 5.0), 0.3,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["stiffness", "pressure", "friction"])
def test_odd_numbers_are_refused_by_name(name):
    for odd in [*ODD, -1.0, np.float32(np.nan), np.array([1.0])]:
        with pytest.raises(ValueError, match=f"{name} = "):
            replace(column(), **{name: odd})
    good = getattr(column(), name)
    for number in (np.float64(good), np.array(good)):
        assert getattr(replace(column(), **{name: number}), name) == good


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"normal_forces": np.full(2, 1e139), "pressure": 1e-139}, "grain 0 do not balance"),
        ({"positions": np.zeros((3, 2))}, r"contact 0 \(0, 1\) joins two centres at one point"),
        ({"radii": np.full(3, 1e-300)}, "grain 0 has radius 1e-300, below 1e-140"),
        ({"cell": np.zeros((2, 2))}, "is singular"),
        ({"cell": np.full((2, 2), 1e139)}, "is singular"),
        (
            {"cell": 1e139 * np.eye(2), "images": np.full((2, 2), 2**52)},
            r"contact 0 \(0, 1\) does not touch",
        ),
    ],
)
def test_numbers_that_overflow_on_the_way_are_refused_quietly(change, message):
    with pytest.raises(ValueError, match=message):
        replace(column(), **change)


def test_no_grains_are_no_packing():
    with pytest.raises(ValueError, match="radii is empty"):
        Packing(np.empty((0, 2)), [], None, [], [], [], [], np.empty((0, 3)), 1.0, 1.0, 0.3)


@pytest.mark.parametrize("unit", [2.0**-30, 2.0**30])
def test_touching_knows_no_unit(unit):
    """A gap of 1e-10 diameters is no contact, whatever the diameter is called."""
    p = column()
    lengths = ("positions", "radii", "normal_forces", "tangential_forces")
    scaled = {name: unit * getattr(p, name) for name in lengths}
    scaled["external"] = p.external * [unit, unit, unit**2]
    assert replace(p, **scaled).overlaps == pytest.approx(unit * p.overlaps, rel=1e-12)
    apart = p.positions.copy()
    apart[2, 0] += 1e-3 + 1e-10
    with pytest.raises(ValueError, match=r"contact 1 \(1, 2\) does not touch"):
        replace(p, **scaled | {"positions": unit * apart})


def test_more_can_be_noted():
    """The packing is another, its arrays and what was known are the same."""
    p = replace(column(), provenance=Provenance(seed=1, notes={"by": "hand"}))
    q = p.noted(residual=0.5, wall=3.0)
    assert q.provenance == Provenance(seed=1, residual=0.5, notes={"by": "hand", "wall": 3.0})
    assert p.provenance.residual is None
    assert q.positions is p.positions
    assert not q.positions.flags.writeable


@pytest.mark.parametrize(
    "through", [copy.copy, copy.deepcopy, lambda p: pickle.loads(pickle.dumps(p)), replace]
)
def test_copies_are_read_only_and_equal(through):
    p = packing()
    q = through(p)
    for name in (f.name for f in fields(Packing)):
        one, two = getattr(p, name), getattr(q, name)
        assert np.array_equal(one, two), name
        if isinstance(two, np.ndarray):
            assert not two.flags.writeable, name
    with pytest.raises(AttributeError):
        q.friction = 0.0
