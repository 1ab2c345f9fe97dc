"""The studies behind docs/estimators.md, one module each: see `benchmarks.estimators`."""
