"""What a kernel has to offer: the functions of a module ``disks_NAME`` in this folder.

A new backend is one such file; ``dem.motion.backends`` finds it, and NAME, which is also the
package that it needs, is then a value of ``backend``.
"""

from __future__ import annotations

from typing import Protocol

from dem.model.drive import Drive
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.kernels.motion import Forces, Motion


class Kernel(Protocol):
    """Velocity Verlet with history, as ``disks_numpy`` writes it down."""

    def refuse_law(self, law: ContactLaw) -> None:
        """ValueError, with advice, for a contact law that this kernel does not know."""

    def contact_forces(self, m: Motion, near: Neighbours, law: ContactLaw, dt: float) -> Forces:
        """Forces at the present positions; ``near.elongation`` advanced by the last ``dt``."""

    def advance(
        self,
        m: Motion,
        forces: Forces,
        near: Neighbours,
        law: ContactLaw,
        drive: Drive,
        dt: float,
        steps: int,
        drifted: bool,
    ) -> tuple[int, bool, Forces]:
        """Up to ``steps`` steps, ``m`` changed in place: steps done, drifted, forces.

        Returns early when the neighbour list is used up: drifted, but not yet kicked.
        """
