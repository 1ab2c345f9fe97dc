"""How a packing is brought to rest: numerical settings, apart from the physics of the scene."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from dem.motion.backends import check_backend, check_precision
from packing.arguments.numbers import SMALLEST, flag, number_from_zero, positive_number

#: What each setting may be, in its unit.  Below a skin of 1e-3 the list is made anew at every
#: step; above 2 it holds ten times the pairs that touch.  Nothing rests in hundreds of inertial
#: times with a drag below 0.02 or above 100.  A speed of 1e-12 is round-off; a record of a
#: packing asks for a residual of 1e-2, and a polish that ends above 1e-3 is none.
LIMITS = {
    "drag": (1e-3, 1e3),
    "velocity_tolerance": (1e-12, 1e3),
    "residual_tolerance": (SMALLEST, 1e-3),
    "skin": (1e-3, 2.0),
    "longest": (1e-3, 1e6),
}
#: Grains from which a mean speed is awaited that is lower, as their inverse, since one group that
#: still moves hardly shows in it; and the lowest (√(p/ρ)), which some group never comes below.
LARGE, LOWEST_AWAITED = 1000, 1e-6
#: A time step above this fraction of √(m_eff/κ) may not come to rest: 1.0 does at every Δ, 1.5
#: at none (2 is the stability limit of a single contact, and a grain has several).
LONGEST_TIME_STEP = 1.0
#: The dashpot acts explicitly: above this product with the time step it drives, not damps, and the
#: spring takes its share of stability.  Measured (N = 48, Δ = 1e-1 ... 1e-4): a product of 0.5
#: rests at time steps up to 0.4, of 0.4 up to 0.8, of 0.2 up to 1.0.
LONGEST_DASHPOT_STEP = 0.5


@dataclass(frozen=True)
class Settings:
    """Numerical settings of ``relax``; the defaults are those of the published figures.

    Parameters
    ----------
    time_step : float
        In units of √(m_eff/κ), m_eff half the mass of the lightest grain.  Steps to rest fall as
        its inverse; packings made with 0.2 have the same statistics (docs/trade.md).
    drag : float
        Rate of the viscous drag on grains, rotation and cell, in √(p/ρ)/⟨σ⟩.
    dashpot : float
        Normal contact dashpot in units of √(m κ) of a mean grain; keep it 0 (see ``model.law``).
    velocity_tolerance : float, optional
        Mean speed, in ⟨σ⟩√(p/ρ)/⟨σ⟩, at which integration ends.  None: 1e-5 with the polish, else
        the Comment's 1e-8; in float32 1e-4 and 1e-5.  More than 1000 grains are given 10 000
        steps more to come to 0.01/N, or 1e-6 if that is more.
    residual_tolerance : float
        Largest force or torque residual of a polished packing, in p⟨σ⟩; where Newton's method
        stalls above it, integration goes on.
    skin : float
        Width of the neighbour list beyond touching, in ⟨σ⟩.
    polish : bool
        End with Newton's method on the contacts.
    longest : float
        Inertial times ⟨σ⟩√(ρ/p) after which relaxation is given up.
    backend : str
        "auto", or a kernel of ``dem.motion.backends.BACKENDS``.
    precision : str
        "float64" or "float32", of the time integration; the polish is in float64.  In float32
        rest comes later, or not at all, where Δ and friction are both small: at Δ = 1e-4,
        μ = 1e-3 after ten times as many steps, if it comes.  What does not rest is refused.

    Raises
    ------
    ValueError
        Naming the setting and its value, and the limits that it is outside of (a drag from 1e-3 to
        1e3, a skin from 1e-3 to 2, residual_tolerance up to 1e-3, longest up to 1e6); ``relax``
        refuses what would take more than 1e8 time steps.

    Examples
    --------
    >>> from dem import Settings
    >>> Settings().speed, Settings(polish=False).speed
    (1e-05, 1e-08)
    """

    time_step: float = 0.8
    drag: float = 1.0
    dashpot: float = 0.0
    velocity_tolerance: float | None = None
    residual_tolerance: float = 1e-9
    skin: float = 0.2
    polish: bool = True
    longest: float = 3000.0
    backend: str = "auto"
    precision: str = "float64"

    def __post_init__(self) -> None:
        check_backend(self.backend)
        check_precision(self.precision)
        object.__setattr__(self, "time_step", positive_number("time_step", self.time_step))
        for name, (low, high) in LIMITS.items():
            if name == "velocity_tolerance" and self.velocity_tolerance is None:
                continue
            value = positive_number(name, getattr(self, name))
            if not low <= value <= high:
                raise ValueError(f"{name} = {value} is outside [{low:g}, {high:g}]")
            object.__setattr__(self, name, value)
        object.__setattr__(self, "dashpot", number_from_zero("dashpot", self.dashpot))
        object.__setattr__(self, "polish", flag("polish", self.polish))
        if self.time_step > LONGEST_TIME_STEP:
            raise ValueError(
                f"time_step = {self.time_step} exceeds {LONGEST_TIME_STEP} √(m_eff/κ): "
                "the packing would not come to rest"
            )
        most = LONGEST_DASHPOT_STEP - 0.25 * self.time_step**2
        if self.dashpot > 0 and self.dashpot * self.time_step > most:
            raise ValueError(
                f"dashpot = {self.dashpot} with time_step = {self.time_step} is unstable: their "
                f"product may be {most:.3g} at most"
            )

    def plain(self) -> dict[str, Any]:
        """Its fields as plain values, for the record of a packing."""
        return asdict(self)

    @property
    def speed(self) -> float:
        """The mean speed at which integration ends, in √(p/ρ)."""
        if self.velocity_tolerance is not None:
            return self.velocity_tolerance
        if self.precision == "float32":  # its noise keeps grains at 2e-5 at Δ = 1e-4
            return 1e-4 if self.polish else 1e-5
        return 1e-5 if self.polish else 1e-8

    def awaited(self, grains: int) -> float:
        """The mean speed that so many grains should have before the first polish, if it comes."""
        waits = self.velocity_tolerance is None and self.polish and self.precision == "float64"
        return max(self.speed * min(1.0, LARGE / grains), LOWEST_AWAITED) if waits else self.speed
