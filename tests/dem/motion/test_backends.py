"""A backend is one new file beside the kernels that are there."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from dem import Settings
from dem.motion.backends import BACKENDS, check_backend, kernel_of, known_backends
from dem.motion.kernels.kernel import Kernel

#: A kernel for a package that is surely there, made of another's functions.
NEW = '"""A kernel."""\nfrom dem.motion.kernels.disks_numpy import *\n'
RUN = """
import sys
from importlib import reload
from dem.motion import backends, kernels
kernels.__path__.append(sys.argv[1])
reload(backends)  # found when the house is entered
from dem import Scene, Settings, relax
from dem.motion.backends import BACKENDS
print(*BACKENDS)
for backend in ("numpy", "scipy"):
    packing = relax(Scene(20, 1e-1), 1, settings=Settings(backend=backend), progress=False)
    print(packing.provenance.backend, packing.forces.sum().hex())
"""


def test_kernels_keep_the_protocol():
    wanted = [name for name in vars(Kernel) if not name.startswith("_")]
    assert sorted(wanted) == ["advance", "contact_forces", "refuse_law"]
    for name in BACKENDS[1:]:
        try:
            kernel = import_module(f"dem.motion.kernels.disks_{name}")
        except ImportError:
            continue
        assert all(callable(getattr(kernel, function)) for function in wanted)
    assert kernel_of("numpy").__name__.endswith("disks_numpy")


def test_a_new_file_is_a_new_backend(tmp_path):
    """Found, named, run, recorded; the forces are those of the kernel that it was made of."""
    (tmp_path / "disks_scipy.py").write_text(NEW)
    found = subprocess.run(
        [sys.executable, "-c", RUN, str(tmp_path)], capture_output=True, text=True, check=True,
        cwd=Path(__file__).resolve().parents[3], env=os.environ,
    ).stdout.splitlines()  # fmt: skip
    assert found[0] == "auto numpy numba scipy"
    (one, forces), (two, same) = (line.split() for line in found[1:])
    assert (one, two) == ("numpy", "scipy")
    assert forces == same


def test_a_missing_package_is_named(monkeypatch):
    assert known_backends() == BACKENDS == ("auto", "numpy", "numba")
    monkeypatch.setattr("dem.motion.backends.BACKENDS", (*BACKENDS, "no_such_package"))
    monkeypatch.setattr("dem.motion.backends.find_spec", lambda name: None)
    with pytest.raises(ValueError, match="backend = 'numba' needs the extra 'fast'"):
        Settings(backend="numba")
    with pytest.raises(ValueError, match="'no_such_package' needs the package no_such_package"):
        check_backend("no_such_package")
    assert kernel_of("auto").__name__.endswith("disks_numpy")
