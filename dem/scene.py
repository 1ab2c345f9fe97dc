"""What a packing is made of, before it exists.

A scene fixes the physics and nothing else: Δ = p/κ (the deformation of the grains in mean
diameters), friction, sizes, shape of the cell.  Units: κ = ρ = ⟨σ⟩ = 1, so p = Δ.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from packing.numbers import real_number, whole_number

#: Below three grains there is no loop, hence no force equation.
FEWEST_GRAINS = 3
#: At Δ = 0.2 a contact is squeezed by a fifth of a diameter: no longer a contact of disks.
LARGEST_DELTA = 0.2


@dataclass(frozen=True)
class Scene:
    """A frictional disk packing to be prepared.

    Parameters
    ----------
    grains : number of disks, at least 3.
    delta : Δ = p/κ in (0, 0.2].
    friction : Coulomb coefficient μ >= 0; 0 models neither history nor rotation.
    polydispersity : radii are drawn uniformly within ± this fraction of 1/2, in [0, 1), and then
        rescaled to mean 1/2: the largest of few grains may exceed the fraction by as much as the
        mean that was drawn fell short.
    stiffness_ratio : k_t/k_n > 0 of the tangential spring.
    aspect : width over height of the cell.
    contact : "linear", f_n = κ δ.
    boundary : "periodic", isotropic pressure control.

    Raises
    ------
    ValueError : naming the argument and its value.
    """

    grains: int
    delta: float
    friction: float = 0.3
    polydispersity: float = 0.3
    stiffness_ratio: float = 0.5
    aspect: float = 1.0
    contact: str = "linear"
    boundary: str = "periodic"

    def __post_init__(self) -> None:
        object.__setattr__(self, "grains", whole_number("grains", self.grains))
        for name in ("delta", "friction", "polydispersity", "stiffness_ratio", "aspect"):
            object.__setattr__(self, name, real_number(name, getattr(self, name)))
        if self.grains < FEWEST_GRAINS:
            raise ValueError(f"grains = {self.grains}: a packing needs at least {FEWEST_GRAINS}")
        if not 0 < self.delta <= LARGEST_DELTA:
            raise ValueError(f"delta = {self.delta} is outside (0, {LARGEST_DELTA}]")
        if not (isfinite(self.friction) and self.friction >= 0):
            raise ValueError(f"friction = {self.friction} is not a finite number >= 0")
        if not 0 <= self.polydispersity < 1:
            raise ValueError(f"polydispersity = {self.polydispersity} is outside [0, 1)")
        for name in ("stiffness_ratio", "aspect"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ValueError(f"{name} = {value} is not a finite number > 0")
        if self.contact != "linear":
            raise ValueError(f"contact = {self.contact!r} is not built yet; use 'linear'")
        if self.boundary != "periodic":
            raise ValueError(f"boundary = {self.boundary!r} is not built yet; use 'periodic'")

    @property
    def pressure(self) -> float:
        """The pressure p = Δ κ, with κ = 1."""
        return self.delta
