"""The theory in exact arithmetic: derived by sympy, every step checked by sympy.

    derivation()           the Comment's argument as checked steps
    triangle() ...         small networks with exact M, Q, G; `table()` of ranks and squared gains
    perturbation_steps()   noise in sizes and positions to second order
    common_mode_steps()    a factor common to all sizes
    wall_steps()           walls, and corner() ... small networks between them
    inputs.hertz, loops.hertz_series   contact laws beyond linear order
    numeric.lambdify       the one way to NumPy

This package is imported explicitly: `import scaling` does not load sympy.
"""

from scaling.symbolic.argument.common_mode import common_mode_steps
from scaling.symbolic.argument.derivation import derivation
from scaling.symbolic.argument.perturbation_steps import perturbation_steps
from scaling.symbolic.argument.step import Step
from scaling.symbolic.loops.closed_forms import (
    bowtie_gain,
    rhombus_gain,
    square_gain,
    triangle_gain,
)
from scaling.symbolic.loops.fourier import ring_squared_gain
from scaling.symbolic.loops.gain import loop_gaps, squared_gain
from scaling.symbolic.loops.linear_algebra import null_space, pseudo_inverse, rank
from scaling.symbolic.loops.named_networks import bowtie, rhombus, ring, square, triangle, wheel
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork
from scaling.symbolic.loops.table import table
from scaling.symbolic.loops.wheel_waves import wheel_squared_gain
from scaling.symbolic.walls.by_hand import bridge, column, corner, heap, slit
from scaling.symbolic.walls.wall_steps import wall_steps
from scaling.symbolic.walls.walled_network import WalledNetwork

__all__ = [
    "Step",
    "SymbolicNetwork",
    "WalledNetwork",
    "bowtie",
    "bowtie_gain",
    "bridge",
    "column",
    "common_mode_steps",
    "corner",
    "derivation",
    "heap",
    "loop_gaps",
    "null_space",
    "perturbation_steps",
    "pseudo_inverse",
    "rank",
    "rhombus",
    "rhombus_gain",
    "ring",
    "ring_squared_gain",
    "slit",
    "square",
    "square_gain",
    "squared_gain",
    "table",
    "triangle",
    "triangle_gain",
    "wall_steps",
    "wheel",
    "wheel_squared_gain",
]
