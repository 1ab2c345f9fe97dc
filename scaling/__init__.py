"""The numeric force equation of a packing and its error theory.

    ContactNetwork -> force_equation -> reconstruct -> relative_error against ξ/Δ

Knows no simulation: networks are plain arrays, from anybody's packing. The sign convention is
drawn in `scaling.geometry.contact_network`.
"""

from packing.contacts.contact_search import infer_contacts
from packing.version import __version__
from scaling.algebra.conditioning import Conditioning
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.flat_guess import flat_guess
from scaling.estimators.misfit import ImplausibleNoiseWarning
from scaling.estimators.plausibility import BeyondFrictionWarning
from scaling.estimators.reconstruct import reconstruct
from scaling.estimators.reconstruction import Reconstruction
from scaling.estimators.to_pressure import to_pressure
from scaling.geometry.coarse_coordinates import CoarseCoordinatesWarning
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.tiling import tiled, tiled_forces
from scaling.geometry.topology.loops import Loops
from scaling.noise.conventions import perturb
from scaling.noise.systematic import rescaled, rounded
from scaling.observables.stress import stress
from scaling.uncertainty.amplification import amplification, amplification_of
from scaling.uncertainty.collapse import collapse
from scaling.uncertainty.cramer_rao import cramer_rao
from scaling.uncertainty.credible_intervals import credible_intervals
from scaling.uncertainty.error_map import ErrorMap
from scaling.uncertainty.gain import gain
from scaling.uncertainty.map_of_method import error_map, worst_pattern
from scaling.uncertainty.relative_error import mean_force, relative_error
from scaling.uncertainty.wrong_stiffness import forces_of_overlaps, stiffness_response

__all__ = [
    "BeyondFrictionWarning",
    "CoarseCoordinatesWarning",
    "Conditioning",
    "ContactNetwork",
    "ErrorMap",
    "ForceEquation",
    "ImplausibleNoiseWarning",
    "Loops",
    "Prior",
    "Reconstruction",
    "__version__",
    "amplification",
    "amplification_of",
    "collapse",
    "cramer_rao",
    "credible_intervals",
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
