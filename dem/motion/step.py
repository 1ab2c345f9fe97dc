"""Advance a state in time: the bare integrator, in one call.

Velocity Verlet with the drag taken implicitly; the slip of a contact over a step is taken in the
frame at mid-step, which keeps the scheme of second order with history.
"""

from __future__ import annotations

from dem.model.drive import Drive
from dem.model.law import ContactLaw
from dem.motion.simulation import Simulation
from dem.motion.state import State


def step(
    state: State,
    law: ContactLaw,
    dt: float,
    *,
    drive: Drive = Drive(),  # noqa: B008  (frozen)
    steps: int = 1,
    skin: float | None = None,
    backend: str = "auto",
    precision: str = "float64",
) -> State:
    """Advance ``state`` by ``steps`` time steps ``dt``, in place.

    Parameters
    ----------
    state : State
        Positions, velocities and spins of one and the same time, before and after.
    law : ContactLaw
        Forces at contacts.  With μ = 0 the history of the state is forgotten.
    dt : float
        Time step.
    drive : Drive
        Without a pressure the cell is fixed: ``state.strain_rate`` is then left as it is and acts
        on nothing, dashpots included.
    steps : int
        How many, from 1 to 1e8.
    skin : float, optional
        Width of a neighbour list beyond touching; it changes the cost, not the result.
    backend : str
        "auto", or a kernel of ``dem.motion.backends.BACKENDS``.
    precision : str
        "float64" or "float32", of positions, velocities and forces while they move; ``state``
        holds float64.  In float32 overlaps are good to 6e-8 ⟨σ⟩ only.

    Returns
    -------
    State
        The same ``state``.

    Raises
    ------
    ValueError
        dt or skin not positive, steps < 1 or > 1e8, pressure control without a cell, a cell too
        narrow for its grains, a skin whose list would not fit into memory, two grains at one
        place, an unknown backend or precision, constants that float32 cannot hold, a contact law
        that the backend or float32 does not know.
    FloatingPointError
        Positions, velocities or cell are no longer finite: the time step was too long.

    Examples
    --------
    >>> from dem import ContactLaw, State, step
    >>> state = State([[0.0, 0.0], [2.0, 0.0]], [0.5, 0.5], velocities=[[1.0, 0.0], [0.0, 0.0]])
    >>> round(float(step(state, ContactLaw(), 0.01, steps=50, backend="numpy").positions[0, 0]), 6)
    0.5
    """
    moved = Simulation(
        state, law, dt, drive=drive, skin=skin, backend=backend, precision=precision
    )
    moved.advance(steps)
    return state
