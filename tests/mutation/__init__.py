"""Mutations of the physics that the tests must notice: ``python -m tests.mutation``.

A mutation replaces one text of one file by another that is wrong: a sign, a factor 2, a term
left out, an index off by one, the smaller for the larger.  The tests named with it must fail.
The lists are fixed, in `scaling`, `dem` and `symbolic`; a text that is not found exactly once is
an error, so that the lists follow the code, and so is a survivor that no reason excuses.
"""
