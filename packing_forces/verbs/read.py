"""``packing-forces read``: any format to npz, with what was understood."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import fields
from pathlib import Path

import numpy as np

from packing.contact_law import ContactLaw, Hertz
from packing.measurement import Measurement
from packing.record import Packing
from packing.writing import write
from packing_forces.answers.answer import Answer
from packing_forces.answers.file_names import stem, to_write
from packing_forces.known.case import law_in_words
from packing_forces.known.loading import loaded

ARRAYS = (
    "positions", "radii", "cell", "pairs", "images", "normals", "normal_forces",
    "tangential_forces", "external",
)  # fmt: skip
NUMBERS = ("stiffness", "pressure", "friction")


def answer(options: Namespace) -> Answer:
    """Read, say, write."""
    data, said = loaded(options.file, options)
    out = Path(options.out or f"{stem(options.file)}.npz")
    made, written = [str(out)], f"written to {out}"
    if out.resolve() == Path(options.file).resolve():
        made, written = [], "nothing to write: the file is an npz"
    elif isinstance(data, Packing) and out.suffix == ".npz":
        data.save(out)
    else:
        made, written = _tables(data, out, options)
    lines = [f"{Path(options.file).name}: {_kind(data)}"]
    lines += [f"  {line}" for line in _held(data)]
    lines += [f"  {note.severity}: {note}" for note in said]
    facts = {
        "file": options.file, "kind": type(data).__name__.lower(), "grains": len(data.positions),
        "contacts": 0 if data.pairs is None else len(data.pairs),
        "known": _known(data), "out": made,
        "notes": [note.plain() for note in said],
    }  # fmt: skip
    return Answer((*lines, written), facts)


def _kind(data: Packing | Measurement) -> str:
    if isinstance(data, Packing):
        return "a packing at rest: forces are known and balance"
    form = f", {data.format}" if data.format else ""
    return f"a measurement{form}: what is missing, or does not balance, is said below"


def _known(data: Packing | Measurement) -> list[str]:
    names = (*ARRAYS, *NUMBERS, "walls")
    return [name for name in names if getattr(data, name, None) is not None]


def _held(data: Packing | Measurement) -> list[str]:
    contacts = "no contacts" if data.pairs is None else f"{len(data.pairs)} contacts"
    cell = "open" if data.cell is None else "periodic"
    lines = [f"{len(data.positions)} grains, {contacts}, {cell}"]
    law = _law(data)
    curved = isinstance(law, Hertz)  # the stiffness of a record is then that at the pressure
    numbers = [
        law_in_words(law) if n == "stiffness" and curved else f"{n} = {getattr(data, n):.6g}"
        for n in NUMBERS
        if getattr(data, n) is not None
    ]
    if numbers:
        lines.append(", ".join(numbers))
    lines.append("known: " + ", ".join(_known(data)))
    missing = [n for n in (*ARRAYS, *NUMBERS) if n not in _known(data)]
    if missing:
        lines.append("not known: " + ", ".join(missing))
    if isinstance(data, Measurement):
        units = [data.length_unit or "?", data.force_unit or "?"]
        lines.append(f"units: lengths in {units[0]}, forces in {units[1]}")
        known = {f.name: getattr(data.uncertainty, f.name) for f in fields(data.uncertainty)}
        told = [f"{k} {np.mean(v):.3g}" for k, v in known.items() if v is not None]
        lines.append("uncertainties: " + (", ".join(told) or "none"))
    return lines


def _law(data: Packing | Measurement) -> ContactLaw | None:
    try:
        return data.law
    except ValueError:  # a law of somebody else's
        return None


def _tables(data: Packing | Measurement, out: Path, options: Namespace) -> tuple[list[str], str]:
    """As tables that can be read again: an npz holds packings at rest."""
    target = out.with_name(out.name.removesuffix(out.suffix) + ".csv")
    name = target.name.removesuffix(".grains.csv").removesuffix(".csv")
    tables = [target.with_name(f"{name}.{kind}.csv") for kind in ("grains", "contacts")]
    if options.out is None and tables[0].resolve() == Path(options.file).resolve():
        return [], "nothing to write: the file is a table, and no packing at rest"
    for table in tables:
        to_write(table, options)
    made = [str(path) for path in write(target, data)]
    why = "" if isinstance(data, Packing) else ": no packing at rest, so tables instead of npz"
    return made, f"written to {' and '.join(made)}{why if out.suffix == '.npz' else ''}"
