"""``packing-forces forces``: by the best method of what is known, as CSV with error bars."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

from packing.writing import write as write_packing
from packing_forces.answers.answer import Answer, Refused
from packing_forces.answers.file_names import stem, to_write
from packing_forces.judging.choice import Choice, choice
from packing_forces.judging.found import Found, find
from packing_forces.judging.table import write
from packing_forces.judging.verdict import errors, verdict
from packing_forces.known.case import Case, facts_of
from packing_forces.known.loading import case_from


def answer(options: Namespace) -> Answer:
    """Choose, solve, write, draw."""
    case = case_from(options.file, options)
    out = to_write(Path(options.out or f"{stem(options.file)}-forces.csv"), options)
    chosen = choice(case, options.method)
    found = find(case, chosen, draws=options.draws)
    if out.suffix == ".vtk":
        _write_vtk(out, case, found)
    else:
        write(out, case, found)
    lines = [f"{case.name}: {chosen.method}: {chosen.why}", *summary(case, chosen, found)]
    lines.append(f"written to {out}")
    facts = facts_of(case) | solved(case, chosen, found) | {"out": str(out)}
    if options.picture:
        draw(case, found, to_write(Path(options.picture), options))
        lines.append(f"drawn to {options.picture}")
        facts["picture"] = options.picture
    return Answer(tuple(lines), facts)


def _write_vtk(out: Path, case: Case, found: Found) -> None:
    """For ParaView. Refused: contacts were left out of those of the file."""
    if case.network.contacts != len(case.data.pairs if case.data.pairs is not None else ()):
        raise Refused(
            f"{case.name}: {case.network.contacts} contacts bear forces, and the file lists "
            "others too: take CSV"
        )
    write_packing(out, case.data, forces=found.result.forces, errors=found.half)


def summary(case: Case, chosen: Choice, found: Found) -> list[str]:
    """The verdict, the evidence, and warnings."""
    r = found.result
    lines = [f"  {verdict(case, chosen, found)}"]
    lines.append(f"  error bars: {found.bars}")
    misfit = "" if r.misfit is None else f", misfit {r.misfit:.3g}"
    negative = int((r.normal < 0).sum())
    lines.append(
        f"  evidence: imbalance {r.imbalance:.1e} ⟨f_n⟩, solution to {r.error_estimate:.1e}"
        f"{misfit}; {negative} of {len(r.normal)} contacts pull"
    )
    lines += [f"  warning: {said}" for said in found.warned]
    return lines + [f"  warning: {note}" for note in case.notes if note.severity == "warning"]


def solved(case: Case, chosen: Choice, found: Found) -> dict[str, Any]:
    """The same for ``--json``."""
    r = found.result
    return {
        "method": chosen.method, "why": chosen.why, "expected": errors(chosen, found),
        "prefactors": {k: e.prefactor for k, e in chosen.expected.items()},
        "error": found.error, "true_error": found.true_error, "bars": found.bars,
        "verdict": verdict(case, chosen, found), "imbalance": r.imbalance, "misfit": r.misfit,
        "error_estimate": r.error_estimate, "mean_normal_force": float(r.normal.mean()),
        "pulling": int((r.normal < 0).sum()), "warnings": list(found.warned),
        "notes": [note.plain() for note in case.notes],
    }  # fmt: skip


def draw(case: Case, found: Found, path: Path) -> None:
    """The force chains found."""
    from matplotlib.figure import Figure

    from packing_forces.drawing.chains import plot

    figure = Figure(figsize=(6, 6), layout="constrained")
    axes = plot(case.network, found.result, axes=figure.subplots())
    axes.set_title(f"{case.name}: normal forces by {found.method}", fontsize=9)
    figure.savefig(path, dpi=200)
