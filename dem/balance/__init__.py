"""Grains at rest: which contacts bear force, and Newton's method on them."""
