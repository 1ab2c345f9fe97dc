"""Solvers that know no grain: least squares, with conditions, with limits; their evidence."""
