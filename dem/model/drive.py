"""What drives grains to rest: drag and pressure.

    weight      -m g along y
    drag        -γ m v  on grains,  -γ I ω on their rotation,  and -γ on the strain rate e
    cell        W (de/dt + γ e) = Σ f_n r - 2 p A,    W = Σ m ⟨σ⟩²   (intensive time scale)

The drag does the damping.
"""

from __future__ import annotations

from dataclasses import dataclass

from packing.arguments.numbers import number_from_zero, positive_number


@dataclass(frozen=True)
class Drive:
    """Viscous drag, and the pressure that moves the cell.

    Parameters
    ----------
    drag : float
        Rate γ, 1/time.
    pressure : float, optional
        Target p, force per length.  None: the cell is fixed, whatever the strain rate of the
        state, which rests until a pressure moves the cell again.
    gravity : float
        Acceleration g >= 0 along -y.

    Raises
    ------
    ValueError
        A negative drag or gravity, a pressure that is not positive.

    Notes
    -----
    W (de/dt + γ e) = Σ f_n r - 2 p A, with W = Σ m ⟨σ⟩² so that the time scale is intensive.

    Examples
    --------
    >>> from dem import Drive
    >>> Drive(drag=0.1, pressure=1e-2)
    Drive(drag=0.1, pressure=0.01, gravity=0.0)
    """

    drag: float = 0.0
    pressure: float | None = None
    gravity: float = 0.0

    def __post_init__(self) -> None:
        for name in ("drag", "gravity"):
            object.__setattr__(self, name, number_from_zero(name, getattr(self, name)))
        if self.pressure is not None:
            object.__setattr__(self, "pressure", positive_number("pressure", self.pressure))
