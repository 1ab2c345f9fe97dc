"""Who may import whom: data flows one way, and a light import stays light."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def imported(module: Path) -> set[str]:
    """Top-level names of all absolute imports in a file, at any depth."""
    names = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
    return names


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def tops(module: Path) -> set[str]:
    return {name.split(".")[0] for name in imported(module)}


@pytest.mark.parametrize(
    ("package", "forbidden"),
    [
        ("dem", {"scaling", "paper_figs", "tests", "sympy"}),
        ("scaling", {"dem", "paper_figs", "tests"}),
        ("packing", {"dem", "scaling", "paper_figs", "tests", "sympy", "matplotlib"}),
    ],
)
def test_packages_do_not_know_each_other(package, forbidden):
    assert modules(package)
    for module in modules(package):
        assert not tops(module) & forbidden, module.name


def test_only_the_sketch_knows_matplotlib():
    for package in ("dem", "scaling"):
        plotting = [m.stem for m in modules(package) if "matplotlib" in tops(m)]
        assert set(plotting) <= {"sketch"}


def test_numeric_modules_do_not_know_sympy():
    for module in modules("scaling"):
        if "symbolic" not in module.parts:
            assert "sympy" not in tops(module), module.name
            assert "scaling.symbolic" not in imported(module), module.name


@pytest.mark.parametrize("package", ["scaling", "dem"])
def test_import_loads_neither_sympy_nor_matplotlib(package):
    code = (
        f"import sys, {package}; print([m for m in ('sympy', 'matplotlib') if m in sys.modules])"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"


def test_the_check_can_fail(tmp_path):
    """A module that imports dem inside a function is seen."""
    module = tmp_path / "m.py"
    module.write_text("def f():\n    from dem.scene import Scene\n    return Scene\n")
    assert tops(module) == {"dem"}


def test_no_room_is_a_drawer():
    for package in ("dem", "scaling", "paper_figs"):
        for module in modules(package):
            assert module.stem not in {"utils", "util", "helpers", "misc", "common"}, module
