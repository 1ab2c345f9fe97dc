"""Draws from the posterior of `bounded`, and their mean."""
