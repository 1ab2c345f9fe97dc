"""The Comment's argument, step by step, each step checked by sympy.

Inputs: the contact law f_n = κ δ^α (`contact`), force and torque balance of a disk
(`equilibrium`), closure of a loop (`closure`).  They are held against statements that do not
come from them: third law, moment, virtual work and frames (`statics`), the motions of grains and
displaced centres (`kinematics`), the energy of a contact.  Outputs: Eq. 1, its rescaled form
(`force_equation`), the two naive readings of it and why neither happens (`readings`), the
propagation of size noise (`size_noise`); what Δ is (`scales`).

Source: DeGiuli and McElwaine, Comment on Gendelman et al., PRL 116, 078001 (2016).
"""

from __future__ import annotations

from functools import cache

from scaling.symbolic.argument.equation_steps import equation_steps, geometry_steps
from scaling.symbolic.argument.general_triangle import GeneralTriangle
from scaling.symbolic.argument.naive_readings import reading_steps
from scaling.symbolic.argument.scale_steps import scale_steps
from scaling.symbolic.argument.size_noise_steps import error_steps
from scaling.symbolic.argument.statics_steps import statics_steps
from scaling.symbolic.argument.step import Step


@cache
def derivation() -> tuple[Step, ...]:
    """All steps in logical order; `Step.holds` says whether sympy finds a step true."""
    loop = GeneralTriangle()
    return (
        *geometry_steps(loop),
        *statics_steps(loop),
        *equation_steps(loop),
        *reading_steps(loop),
        *error_steps(loop),
        *scale_steps(),
    )
