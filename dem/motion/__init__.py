"""Grains in motion: state, neighbours, the time step."""
