"""The bars: how many orders of magnitude are still to go, and who is shown them."""

from __future__ import annotations

import io
import sys
from math import log10

import numpy as np
import pytest

from dem import NotRelaxed, PolishFailed, Scene, Settings, ramp, relax, stiffen
from dem.protocols.progress import PressureBar, RelaxationBar
from packing.progress import bar, hidden
from tests.conftest import packing

RELAXATION = sys.modules["dem.protocols.relaxation"]
SETTLING = sys.modules["dem.protocols.settling"]


@pytest.mark.parametrize(
    ("speed", "decades"), [(float("inf"), 0.0), (10.0, 0.0), (1e-2, 2.0), (0.0, 5.0)]
)
def test_any_speed_has_its_place_on_the_bar(capsys, speed, decades):
    """None lost yet when the speed is not known, or above that of the start; all when at rest."""
    with RelaxationBar(1e-3, 1e-5, 100, True) as rest:
        rest.show(200, speed)
        assert rest.reached == pytest.approx(decades)
        assert rest.reached < rest.total
    assert rest.reached == rest.total


def test_a_gas_at_rest_is_not_near_its_pressure(capsys):
    """The start is at rest, and has no pressure: two decades of it are to come."""
    with RelaxationBar(1e-3, 1e-5, 100, True, tolerance=0.01) as rest:
        rest.show(200, 1e-6, 1.0)
        assert rest.reached == pytest.approx(3.0)
        rest.show(400, 1e-6, 1e-3)
        assert rest.reached == pytest.approx(5.0)


#: Mean speed in √(p/ρ), error of the pressure, whether the polish was tried and failed: a
#: relaxation at Δ = 1e-3, N = 300, prolonged by three more polishes that fail.
RECORDED = [
    (1.2e-1, 1.6e-2, False), (2.6e-2, 2.9e-3, False), (1.1e-2, 9e-4, False),
    (4.4e-3, 1.6e-4, False), (1.1e-3, 8e-5, False), (2.0e-4, 2.7e-5, False),
    (6.5e-5, 2e-5, False), (2.3e-5, 1.7e-5, False), (7.4e-6, 2.4e-6, True),
    (4.2e-6, 5.1e-6, False), (2.4e-6, 1e-6, False), (1.4e-6, 7e-8, True), (9e-7, 7e-8, False),
    (4.7e-7, 9.7e-8, False), (2.8e-7, 1e-7, False), (1.3e-7, 1e-7, True), (6e-8, 1e-7, False),
    (3e-8, 1e-8, False), (1.2e-8, 1e-8, True), (7e-9, 1e-8, False), (2e-9, 1e-8, False),
]  # fmt: skip


def test_recorded_relaxations_fill_the_bar_at_their_end(capsys):
    """It never goes back, rises at each look, and is full only when the packing is there; the
    decades of speed alone (the control) are full for half of the looks."""
    shares, alone = [], []
    with RelaxationBar(1e-3, 1e-5, 10_000, True) as rest:
        for look, (speed, error, failed) in enumerate(RECORDED):
            rest.show(200 * look, speed, error)
            shares.append(rest.reached / rest.total)
            alone.append(min(log10(1 / speed) / 5, 1.0))
            if failed:
                rest.failed(speed / 10)
    assert np.all(np.diff(shares) > 0)
    assert shares[-1] < 1
    assert rest.reached == rest.total
    assert 0.4 < np.mean(np.array(shares) < 0.85) < 0.6
    assert np.mean(np.array(alone) == 1) > 0.5


@pytest.mark.parametrize("failures", [0, 3])
def test_a_relaxation_fills_its_bar_at_its_end(monkeypatch, capsys, failures):
    """As the relaxation itself reports it, polishes that fail included."""
    shares, left = [], [failures]
    polish = SETTLING.polished

    class Recorder(RelaxationBar):
        def show(self, step, speed, pressure_error=0.0):
            super().show(step, speed, pressure_error)
            shares.append(self.reached / self.total)

        def __exit__(self, *error):
            super().__exit__(*error)
            shares.append(self.reached / self.total)

    def reluctant(*arguments):
        if left[0] > 0:
            left[0] -= 1
            raise PolishFailed("not yet")
        return polish(*arguments)

    monkeypatch.setattr(RELAXATION, "RelaxationBar", Recorder)
    monkeypatch.setattr(SETTLING, "polished", reluctant)
    relax(Scene(24, 1e-3), 1, progress=True)
    assert np.all(np.diff(shares) >= 0)
    assert shares[-1] == 1
    assert max(shares[:-1]) < 1
    assert len(set(shares)) > 0.5 * len(shares)


def test_a_relaxation_that_fails_does_not_fill_its_bar(monkeypatch, capsys):
    bars = []

    class Kept(RelaxationBar):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            bars.append(self)

    monkeypatch.setattr(RELAXATION, "RelaxationBar", Kept)
    with pytest.raises(NotRelaxed):
        relax(Scene(24, 1e-3), 1, settings=Settings(longest=2.0), progress=True)
    assert bars[0].reached < bars[0].total


@pytest.mark.parametrize("end", [1e-6, 1e-1])
def test_decades_of_pressure_are_counted_up_and_down(capsys, end):
    with PressureBar("stage", 1e-3, end, True) as stage:
        seen = []
        for p in np.geomspace(1e-3, end, 7)[1:-1]:
            stage.show(float(p))
            seen.append(stage.reached / stage.total)
    assert seen == pytest.approx(np.arange(1, 6) / 6, abs=1e-3)
    assert stage.reached == stage.total


def long_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bars of what takes long appear at once."""
    monkeypatch.setattr(sys.modules["dem.protocols.progress"], "DELAY", 0.0)


def test_stages_of_ramps_and_continuations_have_bars(monkeypatch, capsys):
    long_run(monkeypatch)
    stiffen(packing(), 1e-5, progress=True)
    assert "stiffening to Δ=1e-05" in capsys.readouterr().err
    ramp(packing(), [2e-3], progress=True)
    assert "Δ=1e-03 → 2e-03" in capsys.readouterr().err
    relax(Scene(24, 1e-7), 1, progress=True)
    assert "stiffening to Δ=1e-07" in capsys.readouterr().err


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Bare:
    """A stream that does not say what it is."""

    def write(self, text: str) -> int:
        raise AssertionError("written to")

    def flush(self) -> None:
        pass


def closed() -> io.StringIO:
    stream = io.StringIO()
    stream.close()
    return stream


@pytest.mark.parametrize(
    "stream", [io.StringIO(), None, closed(), Bare()], ids=lambda s: type(s).__name__
)
def test_nothing_is_shown_but_on_a_terminal(monkeypatch, stream):
    """Not to a file, nor where there is no standard error at all; on a terminal it is."""
    long_run(monkeypatch)
    p, terminal = packing(), Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    relax(Scene(20, 1e-2), 1)
    ramp(p, [1.1e-3])
    stiffen(p, 9e-4)
    if isinstance(stream, io.StringIO) and not stream.closed:
        assert stream.getvalue() == ""
    monkeypatch.setattr(sys, "stderr", terminal)
    relax(Scene(20, 1e-2), 1)
    assert "Δ=1e-02" in terminal.getvalue()
    before = len(terminal.getvalue())
    relax(Scene(20, 1e-2), 1, progress=False)
    assert len(terminal.getvalue()) == before


@pytest.mark.parametrize("stream", [None, closed()], ids=["none", "closed"])
def test_a_bar_asked_for_without_standard_error_is_no_error(monkeypatch, stream):
    monkeypatch.setattr(sys, "stderr", stream)
    assert hidden(True) is True
    relax(Scene(20, 1e-2), 1, progress=True)
    with bar(True, total=3) as shown:
        shown.update()


@pytest.mark.parametrize("progress", [0, 1, "yes", [], np.nan])
def test_progress_is_true_false_or_none(progress):
    p = packing()
    for call in (
        lambda: relax(Scene(20, 1e-2), 1, progress=progress),
        lambda: ramp(p, [2e-3], progress=progress),
        lambda: stiffen(p, 5e-4, progress=progress),
    ):
        with pytest.raises(ValueError, match=r"progress = .* is neither True nor False"):
            call()
