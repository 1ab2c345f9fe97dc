"""What is declared is real: the wheel, its licence and version, and the lowest versions."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from email.parser import Parser
from pathlib import Path
from shutil import copytree, ignore_patterns
from zipfile import ZipFile

import pytest

import dem
import packing
import scaling
from tests.lowest import declared, pinned

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("scaling", "dem", "packing", "packing_forces", "studies", "paper_figs", "benchmarks")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built from a copy of the tree."""
    pytest.importorskip(
        "setuptools", minversion="77.0.3", reason="an older setuptools builds no wheel"
    )
    folder = tmp_path_factory.mktemp("wheel")
    heavy = ignore_patterns(".*", "build", "figures", "notebooks", "*.egg-info", "__pycache__")
    copytree(ROOT, folder / "tree", ignore=heavy)
    run = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--quiet"]
    subprocess.run([*run, "--wheel-dir", folder, folder / "tree"], check=True)
    (path,) = folder.glob("*.whl")
    return path


def test_wheel_declares_its_licence_and_version(wheel):
    with ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        metadata = Parser().parsestr(archive.read(name).decode())
    assert metadata["License-Expression"] == "BSD-3-Clause"
    assert metadata.get_all("License-File") == ["LICENSE"]
    assert metadata["Version"] == scaling.__version__
    assert not [c for c in metadata.get_all("Classifier") if c.startswith("License")]


def test_wheel_holds_every_package_and_nothing_else(wheel):
    """Every module of the packages and their marks of being typed; no tests."""
    held = {n for n in ZipFile(wheel).namelist() if ".dist-info/" not in n}
    modules = (p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))
    assert held == {p.relative_to(ROOT).as_posix() for p in modules} | {
        f"{package}/py.typed" for package in PACKAGES
    }


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The wheel installed beside the packages of this environment: its folder, and how to run."""
    folder = tmp_path_factory.mktemp("installed")
    site, empty = folder / "site", folder / "empty"
    install = [sys.executable, "-m", "pip", "install", "--no-deps", "--quiet", "--target", site]
    subprocess.run([*install, wheel], check=True)
    empty.mkdir()
    run = {"cwd": empty, "env": os.environ | {"PYTHONPATH": str(site)}, "check": True}
    return site, run


def test_the_wheel_does_what_the_readme_says(installed):
    """From an empty folder."""
    site, run = installed
    where = "import dem, scaling, packing; print(*(m.__file__ for m in (dem, scaling, packing)))"
    found = subprocess.run([sys.executable, "-c", where], capture_output=True, text=True, **run)
    assert all(path.startswith(str(site)) for path in found.stdout.split())
    subprocess.run([sys.executable, "-P", ROOT / "tests" / "readme_lines.py"], **run)


def test_verbs_work_from_the_wheel(installed):
    """By the script that the wheel installs, in an empty folder; what is written lies there."""
    site, run = installed
    script = [sys.executable, "-P", site / "bin" / "packing-forces"]
    subprocess.run([*script, "prepare", "p.npz", "--grains", "40"], capture_output=True, **run)
    asked = (
        "import packing_forces, paper_figs.__main__\n"
        "from packing_forces.command_line import main\nprint(packing_forces.__file__)\n"
        "codes = [main([v, 'p.npz']) for v in ('read', 'check', 'forces', 'report')]\n"
        "print([*codes, main(['need'])])"
    )
    words = [sys.executable, "-P", "-c", asked]
    found = subprocess.run(words, capture_output=True, text=True, **run)
    assert found.stdout.startswith(str(site))
    assert found.stdout.endswith("[0, 0, 0, 0, 0]\n")
    held = {p.name for p in run["cwd"].iterdir()}
    assert held == {"p.npz", "p-forces.csv", "p-report.html"}


def test_packages_know_their_version():
    """All three the same, as pyproject.toml has it."""
    version = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.M)[1]
    assert {scaling.__version__, dem.__version__, packing.__version__} == {version}


def test_lowest_versions_are_those_declared():
    """Of the core, of one extra, and of all of them, each name once."""
    assert "scipy==1.12" in pinned(declared())
    assert "clarabel==0.10" in pinned(declared(["convex"]))
    assert not [line for line in pinned(declared(["convex"])) if line.startswith("pytest")]
    names = [line.split("==")[0] for line in pinned(declared())]
    assert len(set(names)) == len(names)
    assert {"numpy", "numba", "clarabel", "pytest", "hypothesis", "dask"} <= set(names)


@pytest.mark.parametrize(
    ("requirements", "message"),
    [
        (["numpy"], "'numpy': expected name>=version"),
        (["numpy<3"], "'numpy<3': expected name>=version"),
        (["a>=1", "a>=2"], "'a>=2': a>=1 stands too"),
    ],
)
def test_requirements_without_a_lowest_version_are_refused(requirements, message):
    with pytest.raises(ValueError, match=message):
        pinned(requirements)
    with pytest.raises(ValueError, match="phrenology: no such extra; there are fast"):
        declared(["phrenology"])
