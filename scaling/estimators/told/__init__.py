"""What an estimator is told besides the geometry: exactly, with an error bar, or not at all."""
