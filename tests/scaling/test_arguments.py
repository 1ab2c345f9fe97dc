"""Arguments of the numeric side: arrays of no numbers, columns of forces, odd scalars, bounds."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from packing.arguments import memory
from scaling import (
    ContactNetwork,
    collapse,
    cramer_rao,
    forces_of_overlaps,
    infer_contacts,
    mean_force,
    perturb,
    relative_error,
    rescaled,
    rounded,
    stiffness_response,
    stress,
    tiled,
    tiled_forces,
    to_pressure,
)
from scaling.noise.conventions import balance_response
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.prefactor import loop_shares
from studies.contact_lists import confusion, list_error
from tests.conftest import packing
from tests.scaling.networks import periodic, triangle
from tests.scaling.packings import network_of

N = network_of(packing())
F = packing().forces
C = N.contacts


def made(**changed):
    fields = {"positions": N.positions, "radii": N.radii, "pairs": N.pairs, "cell": N.cell,
              "images": N.images, "external": N.external}  # fmt: skip
    return ContactNetwork(**(fields | changed))


ARRAYS = {
    "positions": (lambda a: made(positions=a), N.positions),
    "radii": (lambda a: made(radii=a), N.radii),
    "pairs": (lambda a: made(pairs=a), N.pairs),
    "cell": (lambda a: made(cell=a), N.cell),
    "images": (lambda a: made(images=a), N.images),
    "external": (lambda a: made(external=a), N.external),
    "normals": (lambda a: made(normals=a), N.normals),
    "forces of stress": (lambda a: stress(N, a), F),
    "forces of tiled_forces": (lambda a: tiled_forces(N, a, 2), F),
    "forces of to_pressure": (lambda a: to_pressure(N, a, 1e-3), F),
    "forces of balance_response": (lambda a: balance_response(N, a), F),
    "forces of stiffness_response": (lambda a: stiffness_response(N, a, 0.1 * F[:C]), F),
    "spread": (lambda a: stiffness_response(N, F, a), F[:C]),
    "overlaps": (lambda a: forces_of_overlaps(N, a, 1.0), F[:C]),
    "predicted": (lambda a: relative_error(a, F, frictional=True), F),
    "true": (lambda a: relative_error(F, a, frictional=True), F),
    "forces of mean_force": (lambda a: mean_force(a, frictional=True), F),
    "covariance": (lambda a: noise_model(N, covariance=a), np.full(N.grains, 1e-6)),
    "positions of infer_contacts": (
        lambda a: infer_contacts(a, N.radii, cell=N.cell), N.positions,
    ),
    "true_pairs": (lambda a: confusion(N.pairs, N.images, a, N.images), N.pairs),
    "true_images": (lambda a: confusion(N.pairs, N.images, N.pairs, a), N.images),
    "matched": (
        lambda a: list_error(F, F, (a, np.arange(C)), frictional=True), np.arange(C),
    ),
    "xis": (lambda a: collapse([], a, np.random.default_rng(0)), np.array([0.1, 1.0])),
}  # fmt: skip
KINDS = {
    "masked": lambda a: np.ma.masked_array(a, mask=np.arange(a.size).reshape(a.shape) == 1),
    "complex": lambda a: a.astype(complex),
    "dates": lambda a: a.astype("M8[s]"),
    "objects": lambda a: a.astype(object),
    "text": lambda a: a.astype(str),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_that_are_no_numbers_are_refused(name, kind):
    """By name; the same numbers as plain ones are taken."""
    function, array = ARRAYS[name]
    function(array.copy())
    with pytest.raises(ValueError, match=name.split()[0]):
        function(KINDS[kind](array))


@pytest.mark.parametrize("name", [name for name in ARRAYS if name.startswith(("forces", "true"))])
def test_columns_of_forces_are_refused(name):
    """(c, 2) columns f_n, f_t hold 2c numbers, in another order."""
    function, array = ARRAYS[name]
    if array.ndim == 1:
        with pytest.raises(ValueError, match="shape"):
            function(array.reshape(2, -1).T)


SCALARS = {
    "xi": lambda v: perturb(N, v, np.random.default_rng(0)),
    "rng": lambda v: perturb(N, 1e-3, v),
    "noise": lambda v: perturb(N, 1e-3, np.random.default_rng(0), v),
    "network": lambda v: rescaled(v, 0.1),
    "radii": lambda v: rescaled(N, v),
    "positions": lambda v: rescaled(N, positions=v),
    "digits": lambda v: rounded(N, v),
    "copies": lambda v: tiled(N, v),
    "threshold": lambda v: infer_contacts(N.positions, N.radii, v),
    "stiffness": lambda v: forces_of_overlaps(N, F[:C], v),
    "method": lambda v: forces_of_overlaps(N, F[:C], 1.0, v),
    "frictional": lambda v: stiffness_response(N, F, F[:C], v),
    "pressure": lambda v: to_pressure(N, F, v),
    "area": lambda v: stress(triangle(), np.ones(6), area=v),
    "draws": lambda v: collapse([], [1.0], np.random.default_rng(0), draws=v),
    "xi_max": lambda v: collapse([], [1.0], np.random.default_rng(0), xi_max=v),
    "packing": lambda v: collapse(v, [1.0], np.random.default_rng(0)),
    "data": lambda v: cramer_rao(N, data=v),
}
ODD = ["nan", b"1", 1j, np.nan, object(), [1.0, [2.0]], np.ma.masked, {}, -np.inf]


@pytest.mark.parametrize("name", SCALARS)
@pytest.mark.parametrize("value", ODD, ids=lambda v: type(v).__name__)
def test_single_values_of_the_wrong_kind_are_named(name, value):
    with pytest.raises(ValueError, match=name):
        SCALARS[name](value)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"box": np.eye(2) * 9}, "has box, but no cell: call it cell"),
        ({"cell": None, "lattice": np.eye(2)}, "has lattice, but no cell"),
        ({"loads": np.zeros((3, 3))}, "has loads, but no external"),
        ({"pairs": None}, "pairs"),
    ],
)
def test_fields_by_other_names_are_refused(fields, message):
    """A periodic packing whose cell is called box would be read as an open one."""
    n = triangle(0.99)
    given = {"positions": n.positions, "radii": n.radii, "pairs": n.pairs}
    assert ContactNetwork.from_packing(SimpleNamespace(**given)).contacts == 3
    with pytest.raises(ValueError, match=message):
        ContactNetwork.from_packing(SimpleNamespace(**(given | fields)))


@pytest.mark.parametrize("name", ["positions", "radii", "pairs"])
def test_missing_fields_are_named(name):
    given = {"positions": [[0, 0]], "radii": [1.0], "pairs": []}
    del given[name]
    with pytest.raises(ValueError, match=f"has no {name}"):
        ContactNetwork.from_packing(SimpleNamespace(**given))


# --- what an array of forces is ------------------------------------------------------------

positive = st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=20)


@given(positive, positive)
def test_normal_forces_alone_are_never_taken_for_both_kinds(a, b):
    """Forces that push, any even number of them: `frictional` has to be said."""
    f = np.array(a + b + [1.0] * (len(a + b) % 2))
    with pytest.raises(ValueError, match="say frictional=False or True"):
        relative_error(f, f)
    assert relative_error(f, f, frictional=False) == 0
    assert mean_force(f, frictional=False) == pytest.approx(f.mean())


@given(positive, st.data())
def test_cohesive_ones_that_push_on_the_whole_neither(forces, data):
    """A quarter of them may pull."""
    f = np.array(forces * 2)
    pull = data.draw(st.integers(0, len(f) // 4))
    f[np.argsort(f)[:pull]] *= -1
    with pytest.raises(ValueError, match="say frictional"):
        mean_force(f)


@pytest.mark.parametrize("friction", [0.0, 0.01, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_packings_know_and_their_arrays_agree(friction, seed):
    """Objects need no word; arrays of a packing with friction none either, as Σ f_t = 0."""
    p = packing(grains=20, friction=friction, seed=seed, delta=1e-2)
    off = 1.1 * p.forces
    error = relative_error(off, p)
    assert error == relative_error(off, p.forces, frictional=friction > 0)
    assert mean_force(p) == mean_force(p.forces, frictional=friction > 0)
    if friction > 0:
        assert relative_error(off, p.forces) == error
        assert abs(p.tangential_forces.sum()) < 1e-9 * abs(p.tangential_forces).sum()
    else:
        with pytest.raises(ValueError, match="frictional = True, but true says False"):
            relative_error(off, p, frictional=True)


# --- bounded work --------------------------------------------------------------------------


@pytest.mark.parametrize("copies", [10**6, 10**9, 2**70, 10**400])
def test_too_many_copies_are_refused_before_they_are_made(copies):
    for function in (lambda: tiled(N, copies), lambda: tiled_forces(N, F, copies)):
        with pytest.raises(ValueError, match=r"copies = .* (that needs .* GB|is beyond)"):
            function()
    assert tiled(N, 3).grains == 9 * N.grains


def test_what_does_not_fit_into_memory_is_refused(monkeypatch):
    """With a thousandth of a gigabyte: pairs within reach, dense matrices, rows of a table."""
    loop_shares(periodic())
    infer_contacts(N.positions, N.radii, cell=N.cell)
    monkeypatch.setattr(memory, "available", lambda: 1e3)
    with pytest.raises(ValueError, match=r"36 grains has 150 unknowns, for dense matrices"):
        loop_shares(periodic())
    with pytest.raises(ValueError, match=r"threshold = 0, .* pairs are within reach"):
        infer_contacts(N.positions, N.radii, cell=N.cell)
    with pytest.raises(ValueError, match=r"draws = 1000 would make 1e\+03 rows"):
        collapse([packing()], [1.0], np.random.default_rng(0), draws=1000)
