"""Slopes of a contact law at the forces of its contacts: the stiffnesses of the linear response.

    δf_n = s δ(σ - r) ,   s = df_n/dδ ,   s -> 0 with f_n where the law is stiffer than linear

At s = 0 the compliance 1/s in Q (f_n/s) diverges, while the contact itself answers with no force.
Slopes are therefore held above a floor: that changes the errors of the fainter contacts alone,
which are floor times the others', and those of the others by its square.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from packing.contact_law import ContactLaw

FLOOR = 1e-4
"""Over the mean slope."""


def tangent_slopes(law: ContactLaw, normal_forces: Floats) -> Floats:
    """Slopes at normal forces, never below FLOOR times their mean.

    Parameters
    ----------
    law : ContactLaw
        f_n(δ)
    normal_forces : (c,) array
        f_n

    Returns
    -------
    (c,) array
        df_n/dδ, force per length.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.contact_law import Hertz
    >>> s = tangent_slopes(Hertz(1.0), np.array([1.0, 1e-15]))
    >>> f"{s[1] / s[0]:.1e}"
    '5.0e-05'
    """
    slopes = np.asarray(law.slope(law.overlap(normal_forces)), float)
    return np.maximum(slopes, FLOOR * slopes.mean())
