"""A state that is pickled, copied or replaced goes on along the same path."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from dem import ContactLaw, State, step
from tests.dem.gases import dense_gas, pressed

EPS = np.finfo(float).eps
EPS32 = np.finfo(np.float32).eps

WAYS: dict[str, Callable[[State], State]] = {
    "pickle": lambda s: pickle.loads(pickle.dumps(s)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "replace": replace,
    "twice": lambda s: replace(pickle.loads(pickle.dumps(copy.copy(s)))),
}


def moving(dashpot: float, backend: str, precision: str, friction: float = 0.3):
    law = ContactLaw(dashpot=dashpot, friction=friction)

    def go(state: State, steps: int) -> State:
        return step(
            state, law, 0.05, drive=pressed(0.1), steps=steps, skin=0.2, backend=backend,
            precision=precision,
        )  # fmt: skip

    return go


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("dashpot", [0.0, 0.3])
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_copy_goes_where_the_original_goes(backend, way, dashpot, precision):
    """In float64 to 1e4 ε L, which the sums of another list may change; in float32, whose
    displacements count from the new list, to 100 ε₃₂.  Forgetting the forces (the control) shows
    with a dashpot: they depend on the velocities half a step before."""
    go = moving(dashpot, backend, precision)
    state = go(dense_gas(2), 40)
    other, control = WAYS[way](state), replace(state, reached=None)
    for s in (state, other, control):
        go(s, 20)
    tolerance = 1e4 * EPS * state.cell.max() if precision == "float64" else 100 * EPS32
    for name in ("positions", "velocities", "spins", "cell"):
        assert np.abs(getattr(other, name) - getattr(state, name)).max() <= tolerance, name
    if dashpot:
        assert np.abs(control.velocities - state.velocities).max() > 3 * tolerance


@pytest.mark.parametrize("way", WAYS)
def test_the_copy_shares_nothing_that_moves(backend, way):
    """Stepping one leaves the other as it was."""
    go = moving(0.3, backend, "float64")
    state = go(dense_gas(2), 10)
    other = WAYS[way](state)
    before = {k: np.copy(getattr(state, k)) for k in ("positions", "velocities", "spins", "cell")}
    pull = state.reached.forces.pull.copy()
    go(other, 10)
    for name, value in before.items():
        assert np.array_equal(getattr(state, name), value), name
    assert np.array_equal(state.reached.forces.pull, pull)


@pytest.mark.parametrize("name", ["velocities", "positions", "spins", "radii"])
def test_what_is_changed_by_hand_is_felt_at_once(backend, name):
    """Forces kept from before belong to another state then: they are computed anew, as those of
    a state that is built with the changed numbers."""
    go = moving(0.3, backend, "float64")
    state = go(dense_gas(2), 10)
    changed = getattr(state, name) * (1 + 1e-3)
    built = replace(state, **{name: changed}, reached=None)
    replaced = replace(state, **{name: changed})
    getattr(state, name)[:] = changed
    kept = copy.copy(state)
    for s in (built, replaced, state):
        go(s, 1)
    for s in (replaced, state):
        assert np.abs(s.velocities - built.velocities).max() <= 100 * EPS
        assert np.abs(s.positions - built.positions).max() <= 100 * EPS * state.cell.max()
    assert not np.array_equal(kept.positions, state.positions)


def test_a_state_without_motion_has_nothing_to_carry():
    state = dense_gas(0)
    assert replace(state).reached is None
    with pytest.raises(ValueError, match="reached = 3 is no Reached"):
        replace(state, reached=3)
