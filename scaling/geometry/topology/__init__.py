"""Loops of a list of contacts: spanning forest, faces, windings, bridges."""
