"""Large cells end with less drag; the number from which on a cell is large is lowered here."""

import numpy as np
import pytest

from dem import Scene, Settings, packing_key, relax
from dem.balance import shift
from dem.model.large_cells import MANY
from dem.motion.simulation import Simulation
from dem.protocols import plan, relaxation, settling
from dem.protocols.ensembles import key
from dem.protocols.loose_gas import draw_radii
from dem.protocols.plan import CRITICAL, TAIL_DRAG, WAVES_DRAG, Plan

SETTINGS = Settings(backend="numpy")


def tail_drag(grains, delta, failed):
    """Its drag, in that of the settings."""
    scene = Scene(grains, delta)
    made = Plan.of(scene, SETTINGS, draw_radii(Scene(20, delta), np.random.default_rng(1)))
    return made.tail_drive(scene, SETTINGS, failed).drag / made.drive.drag


def test_waves_of_large_cells_are_not_damped_more_than_critically():
    assert tail_drag(MANY, 1e-2, failed=False) == 1
    assert tail_drag(MANY, 1e-2, failed=True) == TAIL_DRAG
    for failed in (False, True):
        assert tail_drag(MANY + 1, 1e-2, failed) == WAVES_DRAG
        assert tail_drag(10**6, 1e-2, failed) == pytest.approx(CRITICAL / 100)
        assert tail_drag(10**6, 1e-4, failed) == WAVES_DRAG  # stiff grains: faster waves


@pytest.fixture
def small_is_large(monkeypatch):
    """Cells of more than 100 grains, and the drag falls soon."""
    for module in (plan, relaxation, settling, key):
        monkeypatch.setattr(module, "MANY", 100)
    monkeypatch.setattr(relaxation, "CREEPING", 1e-4)


def drags_of_relaxation(monkeypatch, grains):
    """The packing, and the drag of each stride in that of the settings."""
    seen, advance = [], Simulation.advance

    def watched(self, steps):
        seen.append(self.drive.drag / np.sqrt(self.drive.pressure))
        return advance(self, steps)

    monkeypatch.setattr(Simulation, "advance", watched)
    return relax(Scene(grains, 1e-2), 1, settings=SETTINGS, progress=False), seen


def test_the_drag_falls_at_the_end_and_the_packing_rests(monkeypatch, small_is_large):
    packing, drags = drags_of_relaxation(monkeypatch, 150)
    assert packing.residuals().max() < 1e-9
    assert drags[0] == pytest.approx(1)
    assert drags[-1] == pytest.approx(WAVES_DRAG)


def test_smaller_cells_keep_theirs(monkeypatch, small_is_large):
    _, drags = drags_of_relaxation(monkeypatch, 100)
    assert WAVES_DRAG not in np.round(drags, 9)


def test_newton_holds_back_in_large_cells_only(monkeypatch, small_is_large):
    told = []

    class Watched(shift.Shift):
        def __init__(self, grains, large, good):
            told.append(large)
            super().__init__(grains, large, good)

    monkeypatch.setattr("dem.balance.newton.Shift", Watched)
    for grains in (100, 101):
        relax(Scene(grains, 1e-2), 1, settings=SETTINGS, progress=False)
    assert set(told[:1]) == {False}
    assert told[-1] is True


def test_only_names_of_large_packings_know_of_it(monkeypatch):
    """Stored packings of up to 10 000 grains keep their names, since they have not changed."""
    before = [packing_key(Scene(n, 1e-2), 1, SETTINGS) for n in (MANY, MANY + 1)]
    monkeypatch.setattr(key, "LARGE_CELLS", -1)
    after = [packing_key(Scene(n, 1e-2), 1, SETTINGS) for n in (MANY, MANY + 1)]
    assert before[0] == after[0]
    assert before[1] != after[1]
