"""Where the unknowns and the balances of an equation lie, for constrained problems with them."""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from scaling.algebra.multipliers import NOWHERE, Places
from scaling.equation.force_equation import ForceEquation
from scaling.geometry.places import grain_places


def places_of(
    equation: ForceEquation, unknowns: list[Floats | None], everywhere: int, rows: int = 0
) -> Places:
    """Those of blocks of unknowns, of `everywhere` more that meet all, and of the conditions.

    Conditions are the balances, and `rows` more, which meet all.
    """
    grains = grain_places(equation.network)
    blocks = [b for b in unknowns if b is not None]
    if grains is None or len(blocks) < len(unknowns):
        return NOWHERE
    active = equation.matrices.active
    balances = np.tile(grains[active], (equation.M.shape[0] // len(active), 1))
    columns = np.concatenate([*blocks, np.full((everywhere, 2), np.nan)])
    return Places(columns, None if rows else balances)
