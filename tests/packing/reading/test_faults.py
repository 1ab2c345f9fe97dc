"""Every diagnosis by its name: a fault that raises it, with file and line, and a sound file."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dem import Scene, relax
from packing.files.problem import FileProblem
from packing.measurement import Measurement
from packing.note import NAMES, Note
from packing.reading import notes, read
from packing.record import Packing
from packing.writing import write
from tests.conftest import packing
from tests.packing.dumps import Dump

ROOT = Path(__file__).resolve().parents[3]
Edit = Callable[[str], str]
PLAIN = Dump()


@cache
def boxed():
    """A small packing between four walls."""
    return relax(Scene(30, 1e-2, boundary="box"), 3, progress=False)


def dump(folder: Path, how: Dump = PLAIN, of: Packing | None = None) -> Callable[..., Any]:
    """Dumps of a packing, and how they are read."""
    atoms, contacts = how.write(folder, of or packing())
    return partial(read, atoms, contacts=contacts)


def table(folder: Path, of: Packing | Measurement | None = None) -> Callable[..., Any]:
    """Tables of a packing, and how they are read."""
    return partial(read, write(folder / "p.csv", of or packing())[0])


def edited(name: str, edit: Edit) -> Callable[[Path], None]:
    """A fault: the text of a file changed."""

    def damage(folder: Path) -> None:
        path = folder / name
        text = path.read_text()
        new = edit(text)
        assert new != text, "nothing was damaged"
        path.write_text(new)

    return damage


def raw(name: str, edit: Callable[[bytes], bytes]) -> Callable[[Path], None]:
    """A fault: the bytes of a file changed."""

    def damage(folder: Path) -> None:
        path = folder / name
        path.write_bytes(edit(path.read_bytes()))

    return damage


def line(number: int, edit: Edit) -> Edit:
    """The text with one line changed; counted from 0, or from the end."""

    def change(text: str) -> str:
        lines = text.split("\n")
        lines[number] = edit(lines[number])
        return "\n".join(lines)

    return change


def word(number: int, new: str, separator: str) -> Edit:
    """The line with one word changed."""

    def change(text: str) -> str:
        words = text.split(separator)
        words[number] = new
        return separator.join(words)

    return change


def half(text: str) -> str:
    """The first half of the lines."""
    lines = text.split("\n")
    return "\n".join(lines[: len(lines) // 2]) + "\n"


def without(*starts: str) -> Edit:
    """The text without the lines that begin so."""
    return lambda text: "".join(
        row for row in text.splitlines(keepends=True) if not row.startswith(starts)
    )


def column(name: str, change: Callable[[float], float | None]) -> Edit:
    """The table with a column changed; removed where it becomes None."""

    def new(text: str) -> str:
        head = next(k for k, row in enumerate(text.split("\n")) if row.startswith(("id,", "i,")))
        lines = text.split("\n")
        at = lines[head].split(",").index(name)
        for k in range(head + 1, len(lines) - 1):
            words = lines[k].split(",")
            value = change(float(words[at]))
            words[at : at + 1] = [] if value is None else [repr(value)]
            lines[k] = ",".join(words)
        if change(1.0) is None:
            lines[head] = ",".join(n for n in lines[head].split(",") if n != name)
        return "\n".join(lines)

    return new


def both(*edits: Edit) -> Edit:
    """One change after the other."""

    def change(text: str) -> str:
        for edit in edits:
            text = edit(text)
        return text

    return change


@dataclass(frozen=True)
class Fault:
    """``name`` of the note; ``sound`` writes and reads; ``damage``; ``options`` of the second
    read; ``line`` whether the note has one."""

    name: str
    sound: Callable[[Path], Callable[..., Any]]
    damage: Callable[[Path], Any] = lambda folder: None
    options: tuple[tuple[str, Any], ...] = ()
    line: bool = True


ATOMS, CONTACTS = "a.atoms.dump", "a.contacts.dump"
GRAINS, PAIRS = "p.grains.csv", "p.contacts.csv"
facts = without("# law", "# stiffness", "# pressure", "# rows")
FAULTS = [
    Fault("cut-short", dump, edited(ATOMS, half)),
    Fault("cut-short", dump, edited(CONTACTS, half)),
    Fault("cut-short", dump, raw(CONTACTS, lambda data: data[:-1])),
    Fault("cut-short", table, edited(PAIRS, half)),
    Fault("cut-short", table, edited(PAIRS, both(without("# rows"), half))),
    Fault("unknown-format", table, edited(GRAINS, lambda text: "grains and contacts\n")),
    Fault(
        "binary", table, raw(GRAINS, lambda data: data[:99] + b"\0\1\2" + data[99:]), line=False
    ),
    Fault("wrong-encoding", table, raw(GRAINS, lambda data: b"# \xb5m\n" + data)),
    Fault("no-number", table, edited(GRAINS, line(-3, word(1, "x", ",")))),
    Fault("no-number", dump, edited(ATOMS, line(-3, word(2, "1.5", " ")))),
    Fault("no-number", dump, edited(ATOMS, line(-3, word(0, "1_0", " ")))),
    Fault(
        "decimal-comma",
        table,
        edited(
            GRAINS,
            lambda t: re.sub(
                r"(\d),",
                r"\1;",
                without("#")(t).replace("id,x,y,r,fx,fy,torque", "id;x;y;r;fx;fy;torque"),
            ).replace(".", ","),
        ),
    ),
    Fault("not-finite", table, edited(GRAINS, line(-3, word(1, "nan", ",")))),
    Fault("not-finite", dump, edited(CONTACTS, line(-3, word(4, "1e300", " ")))),
    Fault("uneven-rows", table, edited(GRAINS, line(-9, lambda row: row + ",7"))),
    Fault("missing-column", table, edited(GRAINS, lambda text: text.replace("id,x,y", "id,x,w"))),
    Fault(
        "missing-file",
        lambda folder: (
            lambda **o: o or (dump(folder)() and read(folder / CONTACTS, contacts=folder / ATOMS))
        ),
        lambda folder: read(folder / CONTACTS),
    ),
    Fault("unknown-grain", dump, edited(CONTACTS, line(-3, word(1, "4711", " ")))),
    Fault("unknown-grain", table, edited(PAIRS, line(-3, word(0, "4711", ",")))),
    Fault("grain-twice", table, edited(GRAINS, line(-3, word(0, "1", ",")))),
    Fault("bad-radius", table, edited(GRAINS, line(-3, word(3, "0.0", ",")))),
    Fault("bad-cell", table, edited(GRAINS, lambda t: re.sub("# cell.*", "# cell: 1 2 2 4", t))),
    Fault("no-grains", table, edited(GRAINS, lambda text: ""), line=False),
    Fault(
        "three-dimensional",
        table,
        edited(GRAINS, lambda text: text.replace("torque", "z").replace(",0.0\n", ",0.5\n", 3)),
    ),
    Fault(
        "three-dimensional",
        dump,
        edited(
            ATOMS,
            lambda t: re.sub(
                r"diameter((?:\n.*)*)",
                lambda m: (
                    "diameter z"
                    + m[1].replace("\n", " 1\n").replace(" 1\n", "\n", 1)[:-2]
                    + " 2\n"
                ),
                t[:-1] + " \n",
            ),
        ),
    ),
    Fault("damaged", dump, edited(CONTACTS, lambda text: text.replace("STEP\n0", "STEP\n7"))),
    Fault(
        "listed-twice",
        table,
        edited(PAIRS, both(without("# rows"), lambda text: text + text.split("\n")[-3] + "\n")),
    ),
    Fault(
        "listed-twice",
        table,
        edited(
            PAIRS,
            both(
                without("# rows"),
                lambda text: text + word(-2, "0.5", ",")(text.split("\n")[-3]) + "\n",
            ),
        ),
    ),
    Fault(
        "zero-force",
        table,
        edited(PAIRS, both(without("# rows"), lambda text: text + "0,1,0,0,0.0,0.0,0.0\n")),
    ),
    Fault("open-contacts", table, edited(GRAINS, column("r", lambda r: 0.999 * r)), line=False),
    Fault("diameters-for-radii", table, edited(GRAINS, column("r", lambda r: 2 * r))),
    Fault("diameters-for-radii", table, edited(GRAINS, column("r", lambda r: r / 2))),
    Fault(
        "pixels",
        table,
        edited(
            GRAINS,
            both(
                facts,
                lambda text: text.replace("x,y", "x [px],y [px]"),
            ),
        ),
        line=False,
    ),
    Fault("units-mixed", table, options=(("stiffness", 1e3),)),
    Fault(
        "units-mixed",
        table,
        edited(PAIRS, both(column("fn", lambda f: 1e3 * f), column("ft", lambda f: 1e3 * f))),
    ),
    Fault("viscous-forces", dump, lambda folder: dump(folder, Dump(viscous=1e-6)), line=False),
    Fault("not-at-rest", table, edited(PAIRS, line(-3, word(-2, "0.002", ","))), line=False),
    Fault(
        "missing-walls",
        partial(table, of=boxed()),
        edited(PAIRS, both(without("# rows"), lambda text: re.sub(r"(?m)^\d+,-\d.*\n", "", text))),
        line=False,
    ),
    Fault(
        "missing-walls", partial(table, of=boxed()), edited(GRAINS, without("# wall", "# load"))
    ),
    Fault("beyond-coulomb", table, options=(("friction", 0.01),), line=False),
    Fault("pulling", table, edited(PAIRS, line(-3, word(-2, "-0.1", ","))), line=False),
    Fault(
        "no-forces",
        table,
        edited(PAIRS, both(column("fn", lambda f: None), column("ft", lambda f: None))),
        line=False,
    ),
    Fault("no-radii", table, edited(GRAINS, column("r", lambda r: None)), line=False),
    Fault("no-contacts", table, lambda folder: (folder / PAIRS).unlink(), line=False),
    Fault(
        "no-law", table, edited(GRAINS, both(facts, column("r", lambda r: 0.995 * r))), line=False
    ),
    Fault("frames", dump, lambda folder: dump(folder, Dump(frames=3))),
]


def found(reading: Callable[..., Any], **options: Any) -> list[Note]:
    """What was noted, or what it was refused for."""
    try:
        return list(notes(reading(**options)))
    except FileProblem as refused:
        return [refused.note]


@pytest.mark.parametrize("fault", FAULTS, ids=[f"{k}-{f.name}" for k, f in enumerate(FAULTS)])
def test_a_fault_is_named_and_a_sound_file_is_not(fault, tmp_path):
    reading = fault.sound(tmp_path)
    assert fault.name not in [note.name for note in found(reading)]
    if isinstance(damaged := _damage(fault, tmp_path), Note):
        seen = [damaged]
    else:
        seen = found(reading, **dict(fault.options))
    named = [note for note in seen if note.name == fault.name]
    assert named, [str(note) for note in seen]
    assert named[0].file in {path.name for path in tmp_path.iterdir()}
    assert (named[0].line is not None) or not fault.line, str(named[0])


def _damage(fault: Fault, folder: Path) -> Note | None:
    try:
        fault.damage(folder)
    except FileProblem as refused:
        return refused.note
    return None


@pytest.mark.parametrize(
    ("number", "name", "delta"),
    [("%.6g", "six-digit-coordinates", 1e-4), ("%.4f", "coarse-coordinates", 1e-3)],
)
def test_rounded_coordinates_are_named_with_their_error(number, name, delta, tmp_path):
    """E ≈ 0.7 ξ/⟨δ⟩ is stated: it is right to a factor of two (the rms error of f_n = κ δ)."""
    p = packing(delta=delta)
    assert name not in [note.name for note in found(dump(tmp_path, of=p))]
    reading = dump(tmp_path, Dump(number), p)
    named = next(note for note in found(reading) if note.name == name)
    result = reading()
    i, j = result.pairs.T
    d = result.boundary.branches(result.positions, result.pairs, result.images)
    δ = result.radii[i] + result.radii[j] - np.hypot(*d.T)
    true = dict(zip(map(tuple, p.pairs.tolist()), p.overlaps, strict=True))
    error = δ - [true[tuple(pair)] for pair in result.pairs.tolist()]
    rms = np.sqrt(np.mean(error**2)) / p.overlaps.mean()
    assert 0.3 * rms < named.number < 1.2 * rms


def test_too_large(tmp_path, monkeypatch):
    reading = table(tmp_path)
    monkeypatch.setattr("packing.files.opened.available", lambda: 1000)
    assert [note.name for note in found(reading)] == ["too-large"]


def test_pixels_are_recognised_without_their_name(tmp_path):
    """Radii of whole numbers far above one; with lengths of order one they are none."""
    x, radii = [[0, 0], [59.5, 0], [30.2, 52]], [30, 30, 29]
    pairs, none = [[0, 1], [0, 2], [1, 2]], np.zeros(3)
    m = Measurement(x, radii=radii, pairs=pairs, normal_forces=none + 1)
    assert "pixels" in [note.name for note in found(table(tmp_path, m))]
    small = replace(m, positions=m.positions / 60, radii=m.radii / 60)
    assert "pixels" not in [note.name for note in found(table(tmp_path, small))]


ELSEWHERE = {
    "too-large",
    "six-digit-coordinates",
    "coarse-coordinates",
    "two-sided",
    "guessed",
    "rattlers",
    "balance",
    "overlaps",
    "pressure",
    "units",
}
"""Names with tests of their own, here or beside the format that raises them."""


def test_every_name_has_a_fault():
    assert {fault.name for fault in FAULTS} | ELSEWHERE == set(NAMES)


def test_every_name_in_the_code_is_in_the_list():
    used = set()
    for path in (ROOT / "packing").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call):
                name = getattr(node.func, "id", getattr(node.func, "attr", ""))
                place = {"Note": 1, "note": 1, "problem": 0}.get(name)
                if place is not None and len(node.args) > place:
                    told = node.args[place]
                    either = [told.body, told.orelse] if isinstance(told, ast.IfExp) else [told]
                    used |= {n.value for n in either if isinstance(n, ast.Constant)}
    slugs = {name for name in used if re.fullmatch("[a-z]+(-[a-z]+)*", str(name))}
    assert slugs - set(NAMES) == set()
    assert len(slugs) > 30
