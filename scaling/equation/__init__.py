"""Eq. 1: balance apart from closure, and what its data must obey."""
