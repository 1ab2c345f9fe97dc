"""The shift of the tangent: local, and growing in large cells where the residual does not fall."""

from dataclasses import dataclass

import numpy as np
import pytest

from dem.balance.shift import HOLD, RINGS, SHIFT, Shift


@dataclass
class Chain:
    """Grains in a row, each in touch with the next; all that a shift asks of a trial."""

    grains: int

    @property
    def near(self):
        return self

    @property
    def columns(self):
        return np.array([np.arange(self.grains - 1), np.arange(1, self.grains)])

    @property
    def bearing(self):
        return np.ones(self.grains - 1, bool)


def test_the_shift_reaches_three_contacts_and_no_further():
    residuals = np.zeros(20)
    residuals[10] = 1e-3
    found = Shift(20, False, 1e-9)(Chain(20), residuals)
    near = abs(np.arange(20) - 10) <= RINGS
    assert np.array_equal(found > 0, near)
    assert (found[near] == SHIFT * 1e-3).all()


@pytest.mark.parametrize("large", [False, True])
def test_only_in_large_cells_a_grain_is_held_more_while_its_residual_stays(large):
    shift, residuals = Shift(20, large, 1e-9), np.full(20, 1e-8)
    found = []
    for _ in range(3):
        residuals = residuals.copy()
        residuals[:10] *= 0.1  # these converge, the others do not
        found.append(shift(Chain(20), residuals))
    held = found[-1][-1] / (SHIFT * residuals[-1])
    assert held == (HOLD**2 if large else 1)
    assert found[-1][0] == SHIFT * residuals[0]


def test_what_falls_again_is_let_go_and_what_is_balanced_never_held():
    shift, chain = Shift(4, True, 1e-9), Chain(4)
    for residual, held in [(1e-6, 1), (1e-6, HOLD), (1e-6, HOLD**2), (1e-7, HOLD), (1e-8, 1)]:
        assert shift(chain, np.full(4, residual))[0] == pytest.approx(SHIFT * held * residual)
    for _ in range(3):
        assert shift(chain, np.full(4, 1e-10))[0] == SHIFT * 1e-10
