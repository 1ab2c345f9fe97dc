"""Every set of others ends with a packing or a measurement, with the numbers known of it."""

from __future__ import annotations

import numpy as np
import pytest

from packing.contact_law import Hertz, Linear
from packing.files.problem import FileProblem
from packing.measurement import Measurement
from packing.reading import notes, read
from packing.record import Packing
from packing.seen import Seen
from tests.packing.foreign import foreign

DATA = {
    "henkes_dem/PosVel5000.dat",
    "henkes_dem/Contact5000.dat",
    "henkes_dem/posinit.dat",
    "lammps_walls/hertz.atoms.dump.gz",
    "lammps_walls/hertz.contacts.dump.gz",
    "lammps_walls/hooke.atoms.dump.gz",
    "lammps_walls/hooke.contacts.dump.gz",
    "mercury_square/SquarePackingSelfTest.restart",
    "photoelastic_shear/DSC05384_contacts_directed.csv",
    "photoelastic_shear/DSC05384_solved_Tracke_ParticleData.dlm",
    "photoelastic_shear/DSC05384_solved_Tracke_bonds.txt",
    "photoelastic_shear/DSC05384_solved_Tracke_coordinates.txt",
    "vanhecke_jammed/N16~P1e-3~0001.txt",
    "vanhecke_jammed/N16~P1e-3~9000.txt",
    "vanhecke_jammed/N32~P1e-3~9000.txt",
    "vanhecke_jammed/logN16~P1e-3~0001.txt",
}

REFUSED = {
    "henkes_dem/posinit.dat": "unknown-format",
    "lammps_walls/hertz.contacts.dump.gz": "missing-file",
    "lammps_walls/hooke.contacts.dump.gz": "missing-file",
    "photoelastic_shear/DSC05384_contacts_directed.csv": "missing-file",
    "photoelastic_shear/DSC05384_solved_Tracke_bonds.txt": "unknown-format",
    "photoelastic_shear/DSC05384_solved_Tracke_coordinates.txt": "unknown-format",
    "vanhecke_jammed/logN16~P1e-3~0001.txt": "unknown-format",
}
"""Halves of a set, and what is no packing."""


@pytest.mark.parametrize("name", sorted(DATA))
def test_every_file_ends_with_a_result_or_a_named_refusal(name):
    """Read by itself, without a word said."""
    path = foreign(*name.split("/"))
    if name in REFUSED:
        with pytest.raises(FileProblem) as refused:
            read(path)
        assert (refused.value.note.file, refused.value.note.name) == (path.name, REFUSED[name])
        return
    found = read(path)
    assert isinstance(found, Packing | Measurement)
    assert notes(found)


def names(found):
    return [note.name for note in notes(found)]


@pytest.mark.parametrize(
    ("law", "contacts", "kind", "κ"),
    [("hooke", 265 + 30, Linear, 1e5), ("hertz", 296 + 30, Hertz, 5e4)],
)
def test_box_with_walls_and_weight(law, contacts, kind, κ):
    """168 disks between three walls, gravity 1, at rest to 1e-9: wall and grain forces are the
    law's to 4e-11; nothing is told."""
    folder = foreign("lammps_walls")
    p = read(folder / f"{law}.atoms.dump.gz", contacts=folder / f"{law}.contacts.dump.gz")
    assert isinstance(p, Packing)
    assert (len(p.radii), len(p.pairs), len(p.walls)) == (168, contacts, 3)
    assert sorted(p.walls.normals.tolist()) == [[-1, 0], [0, -1], [1, 0]]
    size = 0.8922871007203041 if law == "hertz" else 1.0  # Hertzian lengths are in ⟨σ⟩
    assert sorted((p.walls.offsets * size).round(9).tolist()) == [0, 0, 13]
    assert isinstance(p.law, kind)
    assert p.law.stiffness / size**2 == pytest.approx(κ, rel=1e-9)
    assert abs(p.law.force(p.overlaps) - p.normal_forces).max() < 4e-11 * p.normal_forces.mean()
    assert p.residuals().max() < 1e-9
    assert -p.external[:, 1] * size**0 == pytest.approx(np.pi * p.radii**2 * size**2, rel=1e-9)
    assert {"guessed", "pressure", "overlaps", "balance"} <= set(names(p))


def test_which_of_the_two_dumps_comes_first_does_not_matter():
    folder = foreign("lammps_walls")
    one, two = folder / "hooke.atoms.dump.gz", folder / "hooke.contacts.dump.gz"
    p, q = read(one, contacts=two), read(two, contacts=one)
    assert np.array_equal(p.normal_forces, q.normal_forces)


def test_sheared_frictional_packing():
    """N = 1024, 1928 contacts, μ = 0.1, Lees-Edwards: forces balance to 2e-5 ⟨f_n⟩ and torques to
    5e-5 (rms), Δ = 1.8e-3, f_n = overlap to 5e-8."""
    p = read(foreign("henkes_dem", "PosVel5000.dat"))
    assert isinstance(p, Packing)
    assert (len(p.radii), len(p.pairs), p.friction, p.stiffness) == (1024, 1928, 0.1, 1.0)
    assert p.delta == pytest.approx(1.8e-3, rel=0.01)
    off = abs(p.normal_forces - p.overlaps)
    assert np.median(off) < 6e-8
    assert off.max() < 2e-7
    net = Seen.of(p).net / p.normal_forces.mean()
    assert np.sqrt(np.mean(net[:, :2] ** 2)) < 2e-5
    assert np.sqrt(np.mean(net[:, 2] ** 2)) < 1e-4
    viscous = [note for note in notes(p) if note.name == "viscous-forces"]
    assert viscous[0].number == pytest.approx(1.9e-4, rel=0.1)
    assert (viscous[0].file, viscous[0].line) == ("Contact5000.dat", 1)
    assert "not-at-rest" not in names(p)


def test_the_shear_matters():
    """Control: without it the listed directions are not those of the positions: refused."""
    with pytest.raises(FileProblem, match=r"Contact5000.dat, line \d+: .* another shear"):
        read(foreign("henkes_dem", "PosVel5000.dat"), lees_edwards=0.25)


@pytest.mark.parametrize(
    ("name", "grains", "contacts"),
    [("N16~P1e-3~0001", 16, 33), ("N16~P1e-3~9000", 16, 33), ("N32~P1e-3~9000", 32, 63)],
)
def test_frictionless_packings_in_a_sheared_cell(name, grains, contacts):
    """Forces from overlaps balance to 1e-12, the virial is the P of the header to 1e-12."""
    p = read(foreign("vanhecke_jammed", f"{name}.txt"))
    assert isinstance(p, Packing)
    assert (len(p.radii), len(p.pairs), p.friction) == (grains, contacts, 0)
    assert p.cell[1, 0] != 0
    assert p.residuals().max() < 1e-11
    assert p.pressure == pytest.approx(1e-3, rel=1e-10)


def test_square_of_disks_under_weight():
    """25 disks, 1 ... 5 weights between rows to 4e-4 of one, four walls, no friction."""
    p = read(foreign("mercury_square", "SquarePackingSelfTest.restart"))
    assert isinstance(p, Packing)
    assert (len(p.radii), len(p.pairs), len(p.walls), p.friction) == (25, 25, 4, 0)
    assert np.sort(p.normal_forces) == pytest.approx(np.repeat([1, 2, 3, 4, 5], 5), abs=4e-4)
    assert p.wall_forces().imag.min() == pytest.approx(-25, abs=2e-3)
    assert p.stiffness == pytest.approx(75857.5125578388, rel=1e-15)
    # Not quite at rest: the overlaps follow the law to 1.6e-6, the columns from 1 weight to 5.
    assert p.residuals().max() < 1e-4


@pytest.mark.parametrize("scale", [None, 2.7e-4])
def test_photoelastic_disks_are_a_measurement(scale):
    """N = 826; forces from both sides differ by 15 % in the median, f_t are not correlated, the
    gaps scatter by 0.017 to 0.022 d, net forces are 0.4 to 0.55 ⟨f_n⟩ with f_t."""
    path = foreign("photoelastic_shear", "DSC05384_solved_Tracke_ParticleData.dlm")
    m = read(path, metre_per_pixel=scale)
    assert isinstance(m, Measurement)
    assert (m.grains, m.contacts) == (826, 802)
    assert m.tangential_forces is None
    assert (m.length_unit, m.force_unit) == ("px" if scale is None else "m", "N")
    assert m.radii.mean() == pytest.approx(24.7 * (scale or 1), rel=0.01)
    two = next(note for note in m.notes if note.name == "two-sided")
    assert two.number == pytest.approx(0.15, abs=0.02)
    assert 0.05 < m.uncertainty.normal_forces / m.normal_forces.mean() < 0.5
    seen = Seen.of(m)
    assert 0.017 < np.std(seen.overlaps) / seen.size < 0.022
    net = np.hypot(*seen.net[:, :2].T)[seen.unbalanced > 0] / m.normal_forces.mean()
    assert 0.4 < net.mean() < 0.8  # with f_t, which counts as not measured, it would be less
    assert {"open-contacts", "not-at-rest", "rattlers"} <= set(names(m))
    assert ("pixels" in names(m)) == (scale is None)
