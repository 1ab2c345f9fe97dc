"""Walls in exact arithmetic: how they close and balance, and small networks solved by hand."""
