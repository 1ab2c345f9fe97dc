"""The Comment's argument, step by step, each step checked by sympy.

Inputs are the contact law f_n = κ δ^α (`contact_law`), force and torque balance of a disk
(`equilibrium`) and closure of a loop (`closure`).  They are held against statements that do not
come from them: third law, moment, virtual work and frames (`statics_steps`), the motions of
grains and displaced centres (`kinematics`), the energy of a contact.  Outputs are Eq. 1 and its
rescaled form (`equation_steps`), the two naive readings of it and why neither happens
(`naive_readings`), the propagation of size noise (`size_noise_steps`), and what Δ is
(`scale_steps`).

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
    """The Comment's argument: all steps in logical order.

    Returns
    -------
    tuple of Step
        From the contact law to the amplification of size noise and the scale Δ. `Step.holds`
        says whether sympy finds a step true.

    Notes
    -----
    Source: DeGiuli and McElwaine, Comment on PRL 116, 078001 (2016). The steps are made in
    `scaling.symbolic.argument`, a module for each part of the argument.

    Examples
    --------
    >>> from scaling.symbolic import derivation
    >>> steps = {step.name: step for step in derivation()}
    >>> steps["Eq. 1"].statement
    'Balance and closure together are the GPPSZ equation.'
    >>> steps["Eq. 1"].holds
    True
    """
    loop = GeneralTriangle()
    return (
        *geometry_steps(loop),
        *statics_steps(loop),
        *equation_steps(loop),
        *reading_steps(loop),
        *error_steps(loop),
        *scale_steps(),
    )
