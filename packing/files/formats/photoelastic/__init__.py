"""Files of photoelastic experiments: PeGS tables, its solved particles, RigidLibrary's exports."""
