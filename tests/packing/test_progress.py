"""Bars of long estimates: on a terminal after a few seconds, never where nobody looks."""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest

from packing import progress
from scaling import error_map, reconstruct
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.bounded.posterior import posterior
from scaling.uncertainty.credible_intervals import posterior_intervals
from tests.conftest import packing
from tests.scaling.packings import network_of

pytest.importorskip("clarabel")


class Terminal(io.StringIO):
    def isatty(self):
        return True


def problem():
    p = packing(grains=20, delta=1e-2)
    return posterior(network_of(p), 1.0, 0.3, None, pressure=p.pressure)


def everything(shown):
    p, rng = packing(grains=20, delta=1e-2), np.random.default_rng
    reconstruct(
        network_of(p), 1.0, "bounded", xi=np.inf, friction=0.3, pressure=p.pressure,
        progress=shown,
    )  # fmt: skip
    posterior_draws(problem(), rng(0), 2, progress=shown)
    truncated_draws(problem(), rng(0), 2, burn_in=1, progress=shown)
    posterior_intervals(problem(), rng(0), draws=20, progress=shown)


@pytest.mark.parametrize(
    ("stream", "shown", "seen"),
    [
        (Terminal, None, True),
        (Terminal, False, False),
        (io.StringIO, None, False),
        (io.StringIO, True, True),
        (lambda: None, None, False),
        (lambda: None, True, False),
    ],
)
def test_bars_are_for_terminals(monkeypatch, stream, shown, seen):
    """With no delay, all that takes long names itself; the control: with three seconds nothing
    here takes so long."""
    for delay in (0.0, progress.DELAY):
        there = stream()
        monkeypatch.setattr(progress, "DELAY", delay)
        monkeypatch.setattr(sys, "stderr", there)
        everything(shown)
        text = "" if there is None else there.getvalue()
        names = ("most probable forces", "projected draws", "exact draws")
        assert all(name in text for name in names) == (seen and delay == 0), text
        assert seen or not text


def test_the_bar_of_an_error_map(monkeypatch):
    """On a terminal, when it takes long; the control: not before the delay."""
    network = network_of(packing(grains=20, delta=1e-2))
    for delay, seen in ((0.0, True), (progress.DELAY, False)):
        terminal = Terminal()
        monkeypatch.setattr(progress, "DELAY", delay)
        monkeypatch.setattr(sys, "stderr", terminal)
        assert error_map(network, "balanced").gain > 0
        assert ("error map of balanced" in terminal.getvalue()) == seen


def test_a_single_call_shows_that_time_goes_on(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr(progress, "BEAT", 0.001)
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.running("waiting"):
        while terminal.getvalue().count("waiting") < 5:
            pass
    with pytest.raises(KeyError), progress.running("failing"):
        raise KeyError


@pytest.mark.parametrize("wrong", ["yes", 1, []])
def test_progress_is_true_false_or_none(wrong):
    message = r"progress = .* is neither True nor False"
    p = packing(grains=20, delta=1e-2)
    given = {"xi": np.inf, "friction": 0.3, "pressure": p.pressure, "progress": wrong}
    with pytest.raises(ValueError, match=message):
        reconstruct(network_of(p), 1.0, "bounded", **given)
    for draws in (posterior_draws, truncated_draws):
        with pytest.raises(ValueError, match=message):
            draws(problem(), np.random.default_rng(0), 2, progress=wrong)
    with pytest.raises(ValueError, match="'gppsz' does not use progress"):
        reconstruct(network_of(p), 1.0, progress=True)
