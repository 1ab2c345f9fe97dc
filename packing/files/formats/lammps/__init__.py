"""Files of LAMMPS and LIGGGHTS: dumps of atoms and of contacts, data files."""
