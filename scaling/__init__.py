"""The numeric force equation of a packing and its error theory.

    ContactNetwork -> force_equation -> reconstruct -> relative_error against ξ/Δ

Knows no simulation: networks are plain arrays, from anybody's packing. The sign convention is
drawn in `scaling.network`.
"""

from scaling.data_collapse import collapse
from scaling.equation import ForceEquation, force_equation
from scaling.error import mean_force, relative_error
from scaling.least_squares import Conditioning
from scaling.loops import Loops
from scaling.network import ContactNetwork
from scaling.noise import perturb
from scaling.propagation import amplification, amplification_of, gain
from scaling.reconstruction import Reconstruction, reconstruct
from scaling.resolution import CoarseCoordinatesWarning
from scaling.virial import stress

__all__ = [
    "CoarseCoordinatesWarning",
    "Conditioning",
    "ContactNetwork",
    "ForceEquation",
    "Loops",
    "Reconstruction",
    "amplification",
    "amplification_of",
    "collapse",
    "force_equation",
    "gain",
    "mean_force",
    "perturb",
    "reconstruct",
    "relative_error",
    "stress",
]
