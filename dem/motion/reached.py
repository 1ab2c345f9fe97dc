"""What the end of one run of steps leaves for the next.

With a dashpot forces depend on the velocities half a step before, which a state does not hold:
computed anew they would be others, and the motion would go on along another path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dem.model.history import History
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.kernels.motion import Forces


@dataclass(frozen=True, eq=False)
class Reached:
    """The ``forces`` where steps ended, ``near`` the list that they were found on.

    ``law`` and whether a pressure ``controlled`` the cell; ``configuration``: copies of all that
    decides forces (of a ``State``), which tell whether they are still those of the state.
    """

    forces: Forces
    near: Neighbours | None
    law: ContactLaw
    controlled: bool
    configuration: dict[str, Any]

    def is_of(self, configuration: dict[str, Any]) -> bool:
        """False when anything that decides forces was changed by hand."""
        return all(_same(configuration[name], kept) for name, kept in self.configuration.items())

    def without_list(self) -> Reached:
        """For copies of the state: kernels change the elongations of the list in place."""
        return self if self.near is None else replace(self, near=None)


def _same(one: Any, two: Any) -> bool:
    if isinstance(one, History):
        return one.same_as(two)
    if isinstance(one, np.ndarray) and isinstance(two, np.ndarray):
        return np.array_equal(one, two)
    return one is two or (one is not None and two is not None and bool(np.all(one == two)))
