"""The forces of the model: contact law and drive.

    normal      f_n = κ δ - c_n dr/dt,  never attractive          δ = σ - r
    tangential  f_t = k_t u,  |f_t| <= μ f_n,   du/dt = (v_j - v_i)·t - R_i ω_i - R_j ω_j
    drag        -γ m v  on grains,  -γ I ω on their rotation,  and -γ on the strain rate e
    cell        W (de/dt + γ e) = Σ f_n r - 2 p A,    W = Σ m ⟨σ⟩²   (intensive time scale)

The drag does the damping.  A contact dashpot is off by default: on the inertial time scale
it acts as a viscosity ~ Δ^(-1/2), and stiff packings creep for ever (Cundall & Strack,
Géotechnique 29, 47 (1979), for springs and slider).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from packing.arguments.numbers import number_from_zero, positive_number


@dataclass(frozen=True)
class ContactLaw:
    """Linear spring, Cundall-Strack spring and slider, optional normal dashpot.

    ``stiffness`` κ (force per length), ``stiffness_ratio`` k_t/κ, ``friction`` μ, ``dashpot``
    c_n (mass per time).  With μ = 0 no history exists and grains do not rotate.
    """

    stiffness: float = 1.0
    stiffness_ratio: float = 0.5
    friction: float = 0.3
    dashpot: float = 0.0

    def __post_init__(self) -> None:
        # Python's floats: a NumPy scalar would widen float32.
        for name in ("stiffness", "stiffness_ratio"):
            object.__setattr__(self, name, positive_number(name, getattr(self, name)))
        for name in ("friction", "dashpot"):
            object.__setattr__(self, name, number_from_zero(name, getattr(self, name)))

    @property
    def tangential(self) -> float:
        """The tangential stiffness k_t."""
        return self.stiffness * self.stiffness_ratio


@dataclass(frozen=True)
class Drive:
    """Drag rate γ (1/time) and target pressure p.

    None: the cell is fixed, whatever the strain rate of the state, which rests until a pressure
    moves the cell again.
    """

    drag: float = 0.0
    pressure: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "drag", number_from_zero("drag", self.drag))
        if self.pressure is not None:
            object.__setattr__(self, "pressure", positive_number("pressure", self.pressure))


def stable_time_step(law: ContactLaw, smallest_mass: float, fraction: float) -> float:
    """``fraction`` of √(m_eff/k), m_eff = m/2 of two of the lightest grains in contact, k the
    larger of κ and 2 k_t: disks roll, hence ω_t² = 3 k_t/m_eff."""
    return fraction * sqrt(0.5 * smallest_mass / max(law.stiffness, 2 * law.tangential))
