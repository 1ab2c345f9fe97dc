"""What forces are before any geometry is measured: f_n = f̄ (m ± a), f_t = 0 ± b f̄.

f̄ = Σ f_n r/Σ r is known, from the pressure or the loads. m = 1, a = 1 and b = 1/2 assume
little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import finite_number, positive_number


@dataclass(frozen=True)
class Prior:
    """Independent Gaussian forces, in units of their mean f̄.

    Parameters
    ----------
    mean : float
        Of f_n, finite
    normal, tangential : float
        Standard deviations of f_n and f_t, positive

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    Forces of packings spread by 0.67 to 0.70 f̄; a wider prior costs where data say little.

    Examples
    --------
    >>> Prior(normal=2.0)
    Prior(mean=1.0, normal=2.0, tangential=0.5)
    """

    mean: float = 1.0
    normal: float = 1.0
    tangential: float = 0.5

    def __post_init__(self) -> None:
        finite_number("prior: mean", self.mean)
        positive_number("prior: normal", self.normal)
        positive_number("prior: tangential", self.tangential)

    def of_contacts(
        self, contacts: int, unknowns: int, closed: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """(unknowns,) means and standard deviations, over f̄; `closed` (c,): the probability P
        that a contact bears a force, 0 else: the mean is P m, the variance P (a² + m²) - P² m²."""
        mean, width = np.zeros(unknowns), np.full(unknowns, float(self.normal))
        mean[:contacts], width[contacts:] = self.mean, self.tangential
        if closed is None:
            return mean, width
        P, m = np.tile(closed, unknowns // contacts), mean
        return P * m, np.sqrt(P * (width**2 + m**2) - (P * m) ** 2)
