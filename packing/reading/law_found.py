"""The contact law of a file: told, shown by forces and overlaps, or not known.

Forces in newtons with overlaps in millimetres, say, show the right law with a κ that is off by a
power of ten: what was told and what is shown agree, or the file is refused.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packing.contact_law import Hertz, Linear, PerContact, law_between
from packing.files.problem import FileProblem
from packing.files.snapshot import Snapshot
from packing.note import Note
from packing.reading.fitted_law import Fit, shown_law
from packing.seen import Seen

GOOD = 0.05
"""A law that leaves less of the forces, rms over mean, is shown by them."""
_CLEAR = 3.0
"""The other law leaves so many times as much."""
_AGREES = 0.05
"""κ told and κ shown agree to this part."""
_VISCOUS = 1e-4
"""A misfit that relative velocities explain, when it is larger than this, is viscous."""


def with_law(s: Snapshot) -> Snapshot:
    """The snapshot with the law that was told, or that its forces and overlaps show.

    FileProblem: κ told and κ shown do not agree.
    """
    seen = Seen.of(s)
    if isinstance(s.law, PerContact):
        return s
    best = None
    if seen.overlaps is not None and seen.normal is not None and len(seen.normal):
        assert s.radii is not None
        best = _clear(*shown_law(seen.overlaps, seen.normal, s.radii, seen.pairs))
    if best is None:
        return _unshown(s, seen)
    if s.law is None:
        return _with_viscous(_shown(s, best), seen, best.misfit)
    if isinstance(s.law, Linear | Hertz) and type(best.law) is type(s.law):
        _refuse_other(s, s.law.stiffness, best.law.stiffness)
    return s


def _clear(best: Fit | None, other: Fit | None) -> Fit | None:
    """The better law, if it is good, and much better than the other."""
    if best is None or best.misfit >= GOOD:
        return None
    return best if other is None or other.misfit > _CLEAR * best.misfit else None


def _shown(s: Snapshot, best: Fit) -> Snapshot:
    """The law shown by the forces, with the κ that was told, if it agrees."""
    if s.stiffness is not None:
        _refuse_other(s, s.stiffness, best.law.stiffness)
    κ = best.law.stiffness if s.stiffness is None else s.stiffness
    law: Linear | Hertz = replace(best.law, stiffness=κ)
    kind = "Hertz, f_n = κ √(4R) δ^(3/2)"
    if isinstance(law, Linear):
        kind = "springs, f_n = κ δ"
        law = Linear(κ, 0.5 if s.stiffness_ratio is None else s.stiffness_ratio)
    note = Note(
        "information",
        "guessed",
        f"forces and overlaps show {kind} with κ = "
        f"{best.law.stiffness:.6g}, to {best.misfit:.1e} of ⟨f_n⟩",
        s.source,
        number=best.misfit,
    )
    return replace(s, law=law, notes=(*s.notes, note))


def _unshown(s: Snapshot, seen: Seen) -> Snapshot:
    """Where forces and overlaps show no law: springs, if κ alone was told; refused, if forces over
    overlaps are another order of magnitude than κ."""
    if s.stiffness is None or s.law is not None:
        return s
    if seen.overlaps is not None and seen.normal is not None and _pushing(seen.overlaps):
        given = float(seen.normal.sum() / seen.overlaps.sum())
        if not 0.1 < given / s.stiffness < 10:
            raise FileProblem(_mixed(s, s.stiffness, given))
    return replace(s, law=Linear(s.stiffness, s.stiffness_ratio or 0.5))


def _pushing(overlaps: np.ndarray) -> bool:
    return bool(len(overlaps) and np.mean(overlaps > 0) > 0.9)


def _refuse_other(s: Snapshot, told: float, shown: float) -> None:
    if abs(told / shown - 1) > _AGREES:
        raise FileProblem(_mixed(s, told, shown))


def _mixed(s: Snapshot, told: float, shown: float) -> Note:
    line = None if s.contact_lines is None or not len(s.contact_lines) else int(s.contact_lines[0])
    return Note(
        "error",
        "units-mixed",
        f"forces over overlaps give κ = {shown:.4g}, but κ = {told:.4g} is "
        f"stated, a factor of {told / shown:.3g}: forces and lengths are not in the units of κ",
        s.contact_source or s.source,
        line,
        told / shown,
    )


def _with_viscous(s: Snapshot, seen: Seen, left: float) -> Snapshot:
    """A note if what the law leaves of f_n follows the relative velocity of the grains."""
    if s.velocities is None or left < _VISCOUS or s.law is None or seen.overlaps is None:
        return s
    assert seen.normal is not None
    assert s.radii is not None
    inner = seen.pairs[:, 1] < seen.grains
    rest = seen.normal - law_between(s.law, s.radii, seen.pairs).force(seen.overlaps)
    i, j = seen.pairs[inner].T
    closing = -np.sum((s.velocities[j] - s.velocities[i])[:, :2] * seen.normals[inner], axis=1)
    rest = rest[inner]
    if not (np.std(rest) > 0 and np.std(closing) > 0):
        return s
    follows = float(np.corrcoef(rest, closing)[0, 1])
    if follows < 0.9:
        return s
    note = Note(
        "warning",
        "viscous-forces",
        f"{left:.2g} of ⟨f_n⟩ is left by the law and follows the "
        f"velocity at which grains approach (correlation {follows:.3f}): it is viscous",
        s.source,
        number=left,
    )
    return replace(s, notes=(*s.notes, note))
