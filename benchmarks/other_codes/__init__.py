"""The same steps and packings by other codes: LAMMPS, and a loop in C."""
