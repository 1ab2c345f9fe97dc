"""What float32 asks of the constants of a motion, and what it cannot do.

Grains move as displacements from where they were when the list was made; the cell, a few
scalars, stays in float64.  Gaps are then good to 6e-8 of a diameter.
"""

from __future__ import annotations

from dem.model.drive import Drive
from dem.model.law import ContactLaw

#: κ, k_t, μ, c_n and the drag are this far from the ends of float32, at 1e38, so that their
#: products with overlaps and speeds are numbers.
LARGEST_IN_SINGLE = 1e30


def check_single(law: ContactLaw, drive: Drive) -> None:
    """ValueError for a law that is not linear, and for constants that float32 cannot hold."""
    if law.linear is None:
        raise ValueError(
            f"contact = {law.contact!r}: precision = 'float32' knows linear springs only; take "
            "'float64'"
        )
    for record, names in (
        (law, ("stiffness", "stiffness_ratio", "friction", "dashpot")),
        (drive, ("drag", "pressure")),
    ):
        for name in names:
            if (value := getattr(record, name) or 0.0) > LARGEST_IN_SINGLE:
                raise ValueError(
                    f"{name} = {value}: precision = 'float32' holds up to {LARGEST_IN_SINGLE:g}"
                )
