"""A compact discrete element method: scene in, packing out.

    packing = relax(Scene(grains=500, delta=1e-4), seed=1)

Units κ = ρ = ⟨σ⟩ = 1, so that the pressure is p = Δ.  This package knows nothing of force
reconstruction; what it hands on is a record of plain arrays, ``Packing``.
"""

from dem.balance.newton import PolishFailed
from dem.model.drive import Drive
from dem.model.history import History
from dem.model.law import ContactLaw
from dem.motion.state import State
from dem.motion.step import step
from dem.protocols.ensembles.ensemble import relax_ensemble
from dem.protocols.ensembles.key import packing_key
from dem.protocols.not_relaxed import NotRelaxed
from dem.protocols.ramp import ramp
from dem.protocols.relax import relax
from dem.protocols.stiffen import refine, stiffen
from dem.scene import Scene
from dem.settings import Settings
from packing.record import Packing
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
