"""The kernels there are, and which of them runs.

A kernel is a module ``dem/motion/kernels/disks_NAME.py`` (see ``kernels.kernel``); NAME is also
the package that it needs.  ``"numpy"`` is the reference, always there; ``"auto"`` takes
``"numba"`` (extra ``fast``) when it is installed.
"""

from __future__ import annotations

import warnings
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pkgutil import iter_modules
from typing import cast

from dem.motion import kernels
from dem.motion.kernels.kernel import Kernel
from packing.arguments.callers import outside
from packing.arguments.numbers import shown

REFERENCE, FASTEST, _PREFIX = "numpy", "numba", "disks_"
#: Extras of this project that install the package of a kernel.
_EXTRAS = {"numba": "fast"}
PRECISIONS = ("float64", "float32")


def known_backends() -> tuple[str, ...]:
    """``"auto"``, the reference, and the others by name; loads none of them."""
    found = {m.name.removeprefix(_PREFIX) for m in iter_modules(kernels.__path__)
             if m.name.startswith(_PREFIX)}  # fmt: skip
    return ("auto", REFERENCE, *sorted(found - {REFERENCE}))


BACKENDS = known_backends()


def check_backend(backend: str) -> str:
    """``backend``; ValueError for an unknown name or a missing package.  Loads nothing."""
    _one_of("backend", backend, BACKENDS)
    if backend != "auto" and find_spec(backend) is None:
        extra = f"the extra {_EXTRAS[backend]!r} (package {backend})" if backend in _EXTRAS else (
            f"the package {backend}")  # fmt: skip
        raise ValueError(f"backend = {backend!r} needs {extra}")
    return backend


def resolve_backend(backend: str) -> str:
    """The name of the kernel that runs; ValueError as ``check_backend``, and when its package is
    installed but cannot be loaded (as "auto" warns then, and takes NumPy)."""
    check_backend(backend)
    if backend == "auto" and find_spec(FASTEST) is None:
        return REFERENCE
    name = FASTEST if backend == "auto" else backend
    if (trouble := _trouble_with(name)) is None:
        return name
    if backend != "auto":
        raise ValueError(f"backend = {backend!r} cannot be loaded: {trouble}")
    warnings.warn(
        f"{name.capitalize()} is installed but cannot be loaded ({trouble}): "
        "the NumPy kernel runs",
        stacklevel=outside(),
    )
    return REFERENCE


def kernel_of(backend: str) -> Kernel:
    """The kernel that runs for ``backend``, loaded."""
    return cast(Kernel, import_module(f"{kernels.__name__}.{_PREFIX}{resolve_backend(backend)}"))


@cache
def _trouble_with(name: str) -> str | None:
    try:
        import_module(f"{kernels.__name__}.{_PREFIX}{name}")
    except Exception as error:  # of a version that does not fit NumPy's, or a broken library
        return f"{type(error).__name__}: {error}"
    return None


def check_precision(precision: str) -> str:
    """``precision``; ValueError for an unknown name."""
    return _one_of("precision", precision, PRECISIONS)


def _one_of(name: str, value: str, known: tuple[str, ...]) -> str:
    if not (isinstance(value, str) and value in known):
        raise ValueError(f"{name} = {shown(value)} is not one of {', '.join(known)}")
    return value
