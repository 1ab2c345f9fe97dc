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
    # A wall meets all grains: its row has no place.
    balances = np.append(grains, [[np.nan, np.nan]], axis=0)[
        equation.matrices.balancing.grain_of_row
    ]
    columns = np.concatenate([*blocks, np.full((everywhere, 2), np.nan)])
    return Places(columns, None if rows else balances)
