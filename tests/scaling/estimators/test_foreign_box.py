"""A box with walls and weight, made by LAMMPS: its forces come out to the digits of its file."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import force_equation, reconstruct
from scaling.estimators import balanced
from tests.scaling import real_packings
from tests.scaling.real_packings import box, jammed, sheared

EPS = np.finfo(float).eps


@pytest.fixture(scope="module")
def lammps():
    return box()


def digits(case) -> float:
    """10 (imbalance of the file + ε L κ)/s_min: what its digits can say of a force."""
    equation = force_equation(case.network)
    imbalance = np.abs(equation.M @ case.forces - equation.balance_rhs()).max()
    size = np.ptp(case.network.positions)
    return 10 * (imbalance + EPS * size * case.stiffness) / equation.conditioning.smallest


def test_the_file_is_what_it_says(lammps):
    """Balanced to 1e-9 under walls and weight, f_n = κ (overlap), Coulomb, 30 wall contacts."""
    n, c = lammps.network, lammps.network.contacts
    assert (n.grains, c) == (168, 265)
    equation = force_equation(n)
    assert np.abs(equation.M @ lammps.forces - equation.balance_rhs()).max() < 1e-9
    normal, tangential = np.split(lammps.forces, 2)
    assert np.abs(normal - lammps.stiffness * n.overlaps).max() < 10 * EPS * 13 * 1e5
    assert np.all(np.abs(tangential) <= lammps.friction * normal)
    assert lammps.masses == pytest.approx(np.pi * n.radii**2, rel=1e-12)
    assert np.sum(lammps.walls[:, 1]) == pytest.approx(lammps.masses.sum(), rel=1e-9)


@pytest.mark.parametrize("method", ["gppsz", "direct", "balanced"])
def test_forces_of_another_code_are_found(lammps, method):
    """Wall forces given as loads.  The bound is 1e-8 of the mean normal force."""
    found = reconstruct(lammps.network, lammps.stiffness, method)
    assert digits(lammps) < 2e-8 * lammps.forces[: lammps.network.contacts].mean()
    allowed = digits(lammps)
    if method == "balanced":
        # It insists on balance, also where a part that hangs on one contact can transmit a moment
        # by its overlap only: with the singular value 1e-7, which G does not have.
        s = np.linalg.svd(balanced.problem(force_equation(lammps.network)).B.toarray())[1]
        allowed *= force_equation(lammps.network).conditioning.smallest / s[s > 1e-12].min()
    assert np.abs(found.forces - lammps.forces).max() <= allowed


def test_every_sign_of_the_file_counts(lammps):
    """Controls: f_t turned round, torques of the walls turned round, and a lever arm that ends at
    the wall instead of at the rim of the grain, which costs Δ: none is within the digits, if such
    loads are not refused at once."""
    c, allowed = lammps.network.contacts, digits(lammps)
    turned = np.concatenate([lammps.forces[:c], -lammps.forces[c:]])
    found = reconstruct(lammps.network, lammps.stiffness).forces
    assert np.abs(found - turned).max() > 1e6 * allowed
    deep = 1 - 1e-4  # distance to the wall over R, about
    for factor in (-1.0, deep):
        loads = np.array(lammps.network.external)
        loads[:, 2] *= factor
        try:
            off = reconstruct(lammps.loaded(loads), lammps.stiffness).forces
        except ValueError:
            continue
        assert np.abs(off - lammps.forces).max() > 1e2 * allowed


def test_without_the_data_of_others_tests_skip_by_name(monkeypatch, tmp_path):
    for value, reason in (
        (None, "names no folder"),
        (str(tmp_path), "not in the folder of PACKING_DATA"),
    ):
        monkeypatch.delenv("PACKING_DATA", raising=False)
        if value is not None:
            monkeypatch.setenv("PACKING_DATA", value)
        for read, name in (
            (lambda: jammed("A.txt"), "vanhecke_jammed/A.txt"),
            (sheared, "henkes"),
        ):
            with pytest.raises(pytest.skip.Exception, match=reason) as skipped:
                read()
            assert name in str(skipped.value)


def test_a_folder_that_is_not_there_is_an_error(monkeypatch, tmp_path):
    """A slip in the variable must not pass for data that nobody has."""
    monkeypatch.setenv("PACKING_DATA", str(tmp_path / "slip"))
    with pytest.raises(pytest.fail.Exception, match="slip: no such folder"):
        sheared()
    assert real_packings.OURS.is_dir()
