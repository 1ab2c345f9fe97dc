"""The Comment's argument, step by step, each step checked by sympy.

Inputs: the contact law f_n = κ δ^α (`contact`), force and torque balance of a disk
(`equilibrium`), closure of a loop (`closure`).  Outputs: Eq. 1, its rescaled form
(`force_equation`), the two naive readings of it, why neither happens, and the propagation of
size noise (`readings`); what Δ is (`scales`).

Source: DeGiuli and McElwaine, Comment on Gendelman et al., PRL 116, 078001 (2016).
"""

from __future__ import annotations

from functools import cache

from scaling.symbolic.force_equation import GeneralTriangle, equation_steps, geometry_steps
from scaling.symbolic.readings import error_steps, reading_steps
from scaling.symbolic.scales import scale_steps
from scaling.symbolic.step import Step


@cache
def derivation() -> tuple[Step, ...]:
    """All steps in logical order; `Step.holds` says whether sympy finds a step true."""
    loop = GeneralTriangle()
    return (
        *geometry_steps(),
        *equation_steps(loop),
        *reading_steps(loop),
        *error_steps(loop),
        *scale_steps(),
    )
