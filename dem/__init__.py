"""A compact discrete element method: scene in, packing out.

    packing = relax(Scene(grains=500, delta=1e-4), seed=1)

Units κ = ρ = ⟨σ⟩ = 1, so that the pressure is p = Δ.  This package knows nothing of force
reconstruction; what it hands on is a record of plain arrays, ``Packing``.
"""

from dem.ensemble import packing_key, relax_ensemble
from dem.integrator import step
from dem.law import ContactLaw, Drive
from dem.packing import Packing
from dem.polish import PolishFailed
from dem.ramp import ramp
from dem.relax import NotRelaxed, relax
from dem.scene import Scene
from dem.settings import Settings
from dem.state import History, State
from dem.stiffen import refine, stiffen
from packing.version import __version__

__all__ = [
    "ContactLaw",
    "Drive",
    "History",
    "NotRelaxed",
    "Packing",
    "PolishFailed",
    "Scene",
    "Settings",
    "State",
    "__version__",
    "packing_key",
    "ramp",
    "refine",
    "relax",
    "relax_ensemble",
    "step",
    "stiffen",
]
