"""The numeric force equation of a packing and its error theory.

    ContactNetwork -> force_equation -> reconstruct -> relative_error against ξ/Δ

Knows no simulation: networks are plain arrays, from anybody's packing. The sign convention is
drawn in `scaling.network`.
"""

from packing.version import __version__
from scaling.bound import cramer_rao
from scaling.calibration import (
    forces_of_overlaps,
    rescaled,
    rounded,
    stiffness_response,
    to_pressure,
)
from scaling.data_collapse import collapse
from scaling.detection import infer_contacts
from scaling.equation import ForceEquation, force_equation
from scaling.error import mean_force, relative_error
from scaling.error_theory import ErrorMap, error_map, worst_pattern
from scaling.least_squares import Conditioning
from scaling.loops import Loops
from scaling.misfit import ImplausibleNoiseWarning
from scaling.network import ContactNetwork
from scaling.noise import perturb
from scaling.plausibility import BeyondFrictionWarning
from scaling.posterior import flat_guess
from scaling.propagation import amplification, amplification_of, gain
from scaling.reconstruction import Reconstruction, reconstruct
from scaling.resolution import CoarseCoordinatesWarning
from scaling.tiling import tiled, tiled_forces
from scaling.virial import stress

__all__ = [
    "BeyondFrictionWarning",
    "CoarseCoordinatesWarning",
    "Conditioning",
    "ContactNetwork",
    "ErrorMap",
    "ForceEquation",
    "ImplausibleNoiseWarning",
    "Loops",
    "Reconstruction",
    "__version__",
    "amplification",
    "amplification_of",
    "collapse",
    "cramer_rao",
    "error_map",
    "flat_guess",
    "force_equation",
    "forces_of_overlaps",
    "gain",
    "infer_contacts",
    "mean_force",
    "perturb",
    "reconstruct",
    "relative_error",
    "rescaled",
    "rounded",
    "stiffness_response",
    "stress",
    "tiled",
    "tiled_forces",
    "to_pressure",
    "worst_pattern",
]
