"""What a file says becomes a packing, if forces are known and balance, or else a measurement.

Forces, overlaps and stiffness have to go together: with f_n = κ δ (or Hertz's law) two of them
give the third, and where all three are there they agree or the file is refused. Lengths of
Hertzian packings are brought to mean diameters, in which κ is a force.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing.contact_law import Hertz, Linear, law_between
from packing.diagnosis import diagnose
from packing.diagnosis.lengths import pixels, sizes
from packing.files.problem import FileProblem
from packing.files.snapshot import Snapshot
from packing.law_record import law_record
from packing.measurement import Measurement, Uncertainty
from packing.note import Note
from packing.provenance import Provenance
from packing.reading.law_found import with_law
from packing.reading.missing_contacts import refuse_half_a_list
from packing.reading.units import in_mean_diameters
from packing.reading.weight import with_weight
from packing.record import Packing
from packing.seen import Seen

RECORD = "reading"
"""The note in the provenance of a packing about its file."""
_REFUSALS = {
    "does not touch": "open-contacts",
    "joins two centres": "damaged",
    "pulls": "pulling",
    "exceeds the Coulomb": "beyond-coulomb",
    "do not balance": "not-at-rest",
    "carry a pressure": "units-mixed",
}


def understood(s: Snapshot, name: str, gravity: Floats | None = None) -> Packing | Measurement:
    """The packing or the measurement; FileProblem: the data contradict each other."""
    for note in sizes(Seen.of(s)):
        raise FileProblem(_placed(note, s))
    s = with_law(s)
    s = with_weight(s, gravity)
    missing = _missing(s)
    if missing is None:
        s = in_mean_diameters(s)
        try:
            packing = _packing(s)
        except ValueError as error:
            refuse_half_a_list(s)
            return _measured(s, name, _refusal(error, s))
        seen = (*pixels(Seen.of(s), s.length_unit), *diagnose(packing))
        found = (*s.notes, *_pressure(s), *_slip(s, packing.friction), *_others(seen, s))
        return noted(packing, s.source, name, found)
    return _measured(s, name, missing)


def noted(packing: Packing, source: str, name: str, found: tuple[Note, ...]) -> Packing:
    """The packing with its file and the notes on record."""
    record = {"source": source, "format": name, "notes": [note.plain() for note in found]}
    return packing.noted(**{RECORD: record})


def _missing(s: Snapshot) -> Note | None:
    """What is needed of a packing, but not there."""
    if s.pairs is None:
        return Note("warning", "no-contacts", "there is no list of contacts", s.source)
    if s.normal_forces is None:
        return Note("warning", "no-forces", "the contacts bear no forces", s.source)
    if s.radii is None:
        return Note("warning", "no-radii", "the grains have no radii", s.source)
    if s.law is None:
        return Note(
            "warning",
            "no-law",
            "overlaps do not show how they become force, and no law was told",
            s.source,
        )
    if not len(s.pairs):
        return Note("warning", "no-contacts", "no contact bears a force", s.source)
    return None


def _packing(s: Snapshot) -> Packing:
    seen = Seen.of(s)
    pressure = seen.virial if s.pressure is None else s.pressure
    scene = {"contact": law_record(s.law)} if isinstance(s.law, Hertz) else None
    f_t, external = s.tangential_forces, s.external
    values: dict[str, Any] = {
        name: getattr(s, name)
        for name in ("positions", "radii", "cell", "normal_forces", "stiffness_ratio", "walls")
    }
    return Packing(
        **values,
        pairs=seen.pairs,
        images=seen.images,
        tangential_forces=np.zeros(len(seen.pairs)) if f_t is None else f_t,
        external=np.zeros((seen.grains, 3)) if external is None else external,
        stiffness=_stiffness(s, pressure),  # type: ignore[arg-type]  # None is refused by name
        pressure=pressure,  # type: ignore[arg-type]
        friction=_friction(seen) if s.friction is None else s.friction,
        provenance=Provenance(scene=scene),
    )


def _stiffness(s: Snapshot, pressure: float | None) -> float | None:
    """κ of springs; p/Δ of Hertz's law, as `dem` has it."""
    if isinstance(s.law, Linear):
        return s.law.stiffness
    if s.stiffness is None and s.law is not None and pressure is not None and pressure > 0:
        return pressure / s.law.delta(pressure)
    return s.stiffness


def _pressure(s: Snapshot) -> tuple[Note, ...]:
    """How the pressure was found, if nobody told it."""
    seen = Seen.of(s)
    if s.pressure is not None:
        return ()
    where = "of the box around the grains" if seen.boundary.area is None else "of the boundary"
    note = Note(
        "information",
        "pressure",
        f"p = Σ f_n r/2A = {seen.virial:.6g}, with the area A = {seen.area:.6g} {where}",
        s.source,
        number=seen.virial,
    )
    return (note,)


def _slip(s: Snapshot, friction: float) -> tuple[Note, ...]:
    """What the friction was taken for, if nobody told it."""
    if s.friction is not None or s.tangential_forces is None:
        return ()
    note = Note(
        "information",
        "guessed",
        f"friction {friction:.6g} is the largest f_t/f_n of a loaded contact: it is no less",
        s.source,
        number=friction,
    )
    return (note,)


def _friction(seen: Seen) -> float:
    """The largest f_t/f_n of contacts that bear a hundredth of the mean force: at least μ."""
    if seen.tangential is None or seen.normal is None:
        return 0.0
    loaded = seen.normal > 0.01 * seen.normal.mean()
    return float((np.abs(seen.tangential[loaded]) / seen.normal[loaded]).max(initial=0.0))


def _measured(s: Snapshot, name: str, why: Note) -> Measurement:
    fields = (
        "positions",
        "radii",
        "cell",
        "pairs",
        "images",
        "normals",
        "normal_forces",
        "tangential_forces",
        "external",
        "walls",
        "stiffness",
        "pressure",
        "friction",
        "law",
        "length_unit",
        "force_unit",
        "source",
    )
    law = s.law
    if law is not None and s.radii is not None and s.pairs is not None:
        law = law_between(law, s.radii, s.pairs)
    uncertainty = Uncertainty(**s.uncertainty)
    values = {k: getattr(s, k) for k in fields} | {"law": law, "uncertainty": uncertainty}
    values["stiffness"] = _stiffness(s, s.pressure)
    try:
        found = Measurement(**values, format=name)
    except ValueError as error:
        raise FileProblem(Note("error", "damaged", str(error), s.source)) from error
    seen = _others(diagnose(found), s)
    notes = (*s.notes, *(() if any(n.name == why.name for n in seen) else (why,)), *seen)
    return replace(found, notes=notes)


def _refusal(error: ValueError, s: Snapshot) -> Note:
    name = next((name for text, name in _REFUSALS.items() if text in str(error)), "damaged")
    return Note("warning", name, f"this is no packing at rest: {error}", s.source)


def _others(found: tuple[Note, ...], s: Snapshot) -> tuple[Note, ...]:
    """Notes whose names are not yet among those of the snapshot, with the file."""
    known = {note.name for note in s.notes}
    return tuple(replace(note, file=s.source) for note in found if note.name not in known)


def _placed(note: Note, s: Snapshot) -> Note:
    line = None if s.grain_lines is None else int(s.grain_lines[0])
    return replace(note, file=s.source, line=line)
