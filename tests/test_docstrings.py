"""One style of docstring for all that users call: numpydoc, complete, with an example."""

from __future__ import annotations

from importlib import import_module

import pytest

validate = pytest.importorskip("numpydoc.validate").validate

CODES = {
    "GL03", "GL06", "GL07", "GL08", "SS01", "PR01", "PR02", "PR03", "PR04", "PR07", "RT01", "RT03",
    "EX01",
}  # fmt: skip
"""Of numpydoc.validate: the parameters are those of the signature, in order, each with a type and
a description; what comes out is described; there is an example; sections in their order."""
MODULES = (
    "dem",
    "packing.boundary",
    "packing.contact_law",
    "packing.note",
    "packing.reading",
    "packing.writing",
    "packing_forces",
    "scaling",
    "scaling.estimators",
    "scaling.symbolic",
)


def public() -> list[str]:
    """What the packages list in ``__all__``: functions and classes."""
    found = set()
    for name in MODULES:
        module = import_module(name)
        found |= {f"{name}.{n}" for n in module.__all__ if callable(getattr(module, n))}
    return sorted(found)


@pytest.mark.parametrize("name", public())
def test_public_names_are_documented(name):
    package, _, short = name.rpartition(".")
    what = getattr(import_module(package), short)
    wanted = CODES
    if isinstance(what, type) and issubclass(what, Exception):
        wanted = CODES - {"EX01", "PR01"}  # raised by others, not made by the user
    elif getattr(what, "_is_protocol", False):
        wanted = CODES - {"PR01"}  # a protocol has no constructor
    errors = [f"{code}: {text}" for code, text in validate(name)["errors"] if code in wanted]
    assert errors == []
