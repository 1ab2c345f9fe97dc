"""From a packing to files: npz, tables, LAMMPS, VTK."""

from packing.writing.write import FORMATS, write

__all__ = ["FORMATS", "write"]
