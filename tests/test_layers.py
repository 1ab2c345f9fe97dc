"""The plan of the house: which room may import from which, and that a light import stays light.

A room is a folder of modules. Imports point from a room to rooms before it in the plan, never
back, wherever the import stands: at the top, in a function, or for types only.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PLAN = (
    "packing.arguments",
    "packing.contacts",
    "packing.boundary",
    "packing.contact_law",
    "packing.note",
    "packing.files",
    "packing.files.formats",
    "packing",
    "packing.diagnosis",
    "packing.reading",
    "packing.writing",
    "dem.model",
    "dem.motion.kernels",
    "dem.motion",
    "dem.balance",
    "dem",
    "dem.protocols",
    "scaling.algebra",
    "scaling.geometry.topology",
    "scaling.geometry",
    "scaling.equation",
    "scaling.noise",
    "scaling.estimators",
    "scaling.uncertainty",
    "scaling.observables",
    "scaling",
    "scaling.symbolic.inputs",
    "scaling.symbolic.loops",
    "scaling.symbolic.argument",
    "scaling.symbolic.walls",
    "scaling.symbolic.numeric",
    "scaling.symbolic",
    "studies",
    "benchmarks",
    "packing_forces.answers",
    "packing_forces.drawing",
    "paper_figs",
    "packing_forces.known",
    "packing_forces.judging",
    "packing_forces.page",
    "packing_forces.verbs",
    "packing_forces",
)
"""Low to high; folders that are not named belong to the room of the folder that they lie in."""
STRANGERS = (("dem", "scaling"), ("scaling", "dem"))
"""The first knows nothing of the second."""
MOST_MODULES = 14


def imported(module: Path) -> set[str]:
    """Names of all that a file imports, at any depth: of modules, and of what is taken of them."""
    names = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def tops(module: Path) -> set[str]:
    return {name.split(".")[0] for name in imported(module)}


def name_of(module: Path) -> str:
    parts = module.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def room_of(name: str, is_face: bool) -> str:
    """The room of a module; the face of a folder (its ``__init__``) belongs to that folder."""
    folder = name if is_face else name.rpartition(".")[0]
    while folder and folder not in PLAN:
        folder = folder.rpartition(".")[0]
    return folder


def house() -> dict[str, Path]:
    packages = dict.fromkeys(room.split(".")[0] for room in PLAN)
    return {name_of(m): m for package in packages for m in modules(package)}


def links(built: dict[str, Path]) -> dict[str, set[str]]:
    """Module -> the modules that it imports; faces, which only hand names on, are no links."""
    faces = {name for name, path in built.items() if path.name == "__init__.py"}
    return {
        name: (imported(path) & set(built)) - faces - {name}
        for name, path in built.items()
        if name not in faces
    }


def climbing(built: dict[str, Path]) -> list[str]:
    """Imports that point upwards in the plan."""
    faces = {name for name, path in built.items() if path.name == "__init__.py"}
    wrong = []
    for name, path in built.items():
        here = PLAN.index(room_of(name, name in faces))
        for other in sorted(imported(path) & set(built)):
            if other in faces and any(
                x.startswith(other + ".") for x in imported(path) & (set(built) - faces)
            ):
                continue  # `from room import module` is an import of the module
            there = PLAN.index(room_of(other, other in faces))
            if there > here and not (name in faces and other.startswith(name)):
                wrong.append(f"{name} imports {other}")
    return wrong


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """What is left when modules that import nothing, or that nobody imports, are taken out, again
    and again: circles, and what lies between two of them."""
    left = {name: set(to) for name, to in graph.items()}
    while True:
        wanted = set().union(*left.values()) & set(left)
        ends = [n for n, to in left.items() if not to & set(left) or n not in wanted]
        if not ends:
            return [sorted(left)] if left else []
        for name in ends:
            del left[name]


def test_imports_point_downward():
    assert climbing(house()) == []


def test_no_circles():
    assert circles(links(house())) == []


@pytest.mark.parametrize(("package", "stranger"), STRANGERS)
def test_packages_do_not_know_each_other(package, stranger):
    assert modules(package)
    assert [m.name for m in modules(package) if stranger in tops(m)] == []


def test_no_room_is_overfull():
    count: dict[Path, int] = defaultdict(int)
    for module in house().values():
        count[module.parent] += module.name != "__init__.py"
    assert {str(k.relative_to(ROOT)): n for k, n in count.items() if n > MOST_MODULES} == {}


def test_no_room_is_a_drawer():
    drawers = {"utils", "util", "helpers", "misc", "common"}
    assert [name for name in house() if name.rpartition(".")[2] in drawers] == []


def test_only_the_sketch_draws():
    for package in ("dem", "scaling", "packing", "studies", "benchmarks"):
        assert {m.stem for m in modules(package) if "matplotlib" in tops(m)} <= {"sketch"}


def test_numeric_modules_do_not_know_sympy():
    for module in [*modules("scaling"), *modules("dem"), *modules("packing")]:
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


def test_the_checks_can_fail(tmp_path, monkeypatch):
    """A module that imports from above inside a function, and for types only, is seen."""
    monkeypatch.setattr("tests.test_layers.ROOT", tmp_path)
    low, high = tmp_path / "packing" / "low.py", tmp_path / "dem" / "high.py"
    for path in (low, high):
        path.parent.mkdir()
    low.write_text("def f():\n    from dem.high import g\n    return g\n")
    high.write_text(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from packing.low import f\n"
    )
    built = {name_of(path): path for path in (low, high)}
    assert climbing(built) == ["packing.low imports dem.high"]
    assert circles(links(built)) == [["dem.high", "packing.low"]]
