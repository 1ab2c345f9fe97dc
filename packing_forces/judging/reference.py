"""Forces at which errors are taken: those of the file, or an estimate of their size.

K of E = K κ ξ/⟨|f|⟩ is geometry; only ⟨|f|⟩, and for noise on positions the turning of directions,
ask for forces. Without forces in the file every contact is given the mean normal force that the
pressure or the loads make (`scaling.flat_guess`), or else the overlaps, f_n = f(σ - r).
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from packing_forces.known.case import Case
from scaling import flat_guess


def reference(case: Case) -> tuple[Floats, str] | None:
    """((2c,) or (c,) forces, where they come from); None where nothing says how large they are."""
    if case.forces is not None:
        return case.forces, "of the file"
    c = case.network.contacts
    try:
        guess = flat_guess(case.network, None if case.network.cell is None else case.pressure)
        return guess[: 2 * c if case.frictional else c], "the mean force that the load makes"
    except ValueError:
        pass
    if case.normal is not None and (case.normal > 0).mean() > 0.5:
        mean, said = np.full(c, case.normal.mean()), "the mean of the normal forces of the file"
    elif case.law is not None and case.network.positions is not None:
        pressed = case.law.force(case.network.overlaps).mean()
        if not pressed > 0:
            return None
        mean, said = np.full(c, pressed), "the mean force of the overlaps"
    else:
        return None
    return (np.concatenate([mean, np.zeros(c)]) if case.frictional else mean), said
