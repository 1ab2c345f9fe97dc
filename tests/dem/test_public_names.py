"""What users call: documented in one style, with examples that run, and no workspace in sight."""

from __future__ import annotations

import doctest
import inspect
import sys
from dataclasses import fields, is_dataclass

import pytest

import dem
from packing.provenance import Provenance

PUBLIC = [getattr(dem, name) for name in dem.__all__ if name != "__version__"] + [Provenance]
#: An error without arguments of its own.
WITHOUT_PARAMETERS = {"PolishFailed"}


@pytest.mark.parametrize("thing", PUBLIC, ids=lambda thing: thing.__name__)
def test_public_names_are_documented_alike(thing):
    """Parameters by their names, in order, and what is returned by functions."""
    if thing.__name__ in WITHOUT_PARAMETERS:
        assert thing.__doc__
        return
    named = [f.name for f in fields(thing) if f.init] if is_dataclass(thing) else []
    named = named or list(inspect.signature(thing).parameters)
    text = inspect.getdoc(thing)
    section = text.split("Parameters\n----------\n")[1].split("\n\n")[0]
    told = [
        name
        for line in section.splitlines()
        if not line.startswith(" ")
        for name in line.split(" : ")[0].split(", ")
    ]
    assert [name for name in named if name not in told] == []
    assert "Examples\n--------\n" in text
    if inspect.isfunction(thing):
        assert "Returns\n-------\n" in text
        assert "Raises\n------\n" in text


@pytest.mark.parametrize("thing", PUBLIC, ids=lambda thing: thing.__name__)
def test_examples_run(thing):
    module = sys.modules[thing.__module__]
    found = doctest.DocTestFinder(recurse=False).find(thing, thing.__name__, module=module)
    for example in found:
        assert doctest.DocTestRunner().run(example).failed == 0


def test_a_state_holds_no_workspace():
    state = dem.State([[0.0, 0.0]], [0.5])
    assert [name for name in vars(state) if name.startswith("_")] == []
