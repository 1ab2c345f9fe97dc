"""The error of a packing that did not come to rest."""

from __future__ import annotations

from typing import Any

from dem.motion.state import State


class NotRelaxed(RuntimeError):
    """The packing did not come to rest.

    Parameters
    ----------
    message : str
        Which packing, what was reached, and advice.
    state : State
        The state reached.
    speed : float
        Mean speed reached, in ⟨σ⟩√(p/ρ)/⟨σ⟩.
    residual : float
        Largest force or torque residual reached, in p⟨σ⟩; NaN if not measured.

    Examples
    --------
    >>> from dem import NotRelaxed, Scene, Settings, relax
    >>> try:
    ...     relax(Scene(20, 1e-2), 1, settings=Settings(longest=2.0), progress=False)
    ... except NotRelaxed as failure:
    ...     print(str(failure)[:31], failure.speed > 1e-5)
    Δ = 0.01, N = 20, seed 1: mean  True
    """

    def __init__(self, message: str, state: State, speed: float, residual: float) -> None:
        super().__init__(message)
        self.state, self.speed, self.residual = state, speed, residual

    def __reduce__(self) -> tuple[Any, ...]:
        """What a worker process sends home: the message, the numbers, the notes."""
        return type(self), (str(self), self.state, self.speed, self.residual), self.__dict__
