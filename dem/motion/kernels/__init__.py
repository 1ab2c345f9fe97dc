"""The inner loop of the time step, one file a backend."""
