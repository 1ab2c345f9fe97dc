"""Packings of other groups, and how each is asked about; paths below the folder PACKING_DATA."""

from __future__ import annotations

LAMMPS = "lammps_walls"
SETS = {
    "henkes_dem": ("henkes_dem/PosVel5000.dat",),
    "photoelastic_shear": ("photoelastic_shear/DSC05384_solved_Tracke_ParticleData.dlm",),
    "vanhecke_jammed, N16~0001": ("vanhecke_jammed/N16~P1e-3~0001.txt",),
    "vanhecke_jammed, N16~9000": ("vanhecke_jammed/N16~P1e-3~9000.txt",),
    "vanhecke_jammed, N32~9000": ("vanhecke_jammed/N32~P1e-3~9000.txt",),
    "lammps_walls, hooke": (f"{LAMMPS}/hooke.atoms.dump.gz", f"{LAMMPS}/hooke.contacts.dump.gz"),
    "lammps_walls, hertz": (f"{LAMMPS}/hertz.atoms.dump.gz", f"{LAMMPS}/hertz.contacts.dump.gz"),
    "mercury_square": ("mercury_square/SquarePackingSelfTest.restart",),
}
"""Name -> (file, file of contacts if it is another)."""


def words(files, folder):
    """The file, and its contacts, as on a command line."""
    first, *second = (folder / name for name in files)
    return [first, *(("--contacts", second[0]) if second else ())]
