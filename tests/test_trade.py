"""The parts behind docs/trade.md, ramps.md and speed.md: with error bars, as the pages say."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from benchmarks import ensembles, numbering, polish_cost, precision, size
from studies.error_bars import exponent, spread
from studies.packings import continuation, ramps
from tests.conftest import packing

ROOT = Path(__file__).resolve().parent.parent
PAGES = [
    ROOT / "docs" / name
    for name in ("trade.md", "ramps.md", "speed.md", "limits.md", "physics.md")
]
SHOWN = (
    "step_cost", "size", "numbering", "precision", "polish_cost", "ramp_rates", "continuation",
    "large_packings", "cost_model", "error_theory", "same_statistics", "late_drag", "hertz",
    "lammps_hertz", "c_step", "between_walls", "lammps_walls", "lammps_wall_step",
)  # fmt: skip


def lines_of(name: str) -> list[str]:
    text = (ROOT / "results" / f"{name}.md").read_text()
    return [line for line in text.splitlines() if line.startswith("|")]


@pytest.mark.parametrize("name", SHOWN)
def test_the_tables_of_the_page_are_those_of_the_results(name):
    docs = [line for page in PAGES for line in page.read_text().splitlines()]
    lines = lines_of(name)
    assert len(lines) >= 4
    for line in lines:
        assert line in docs, line


def test_the_exponents_of_the_page_are_those_of_the_solvers():
    docs = [line for page in PAGES for line in page.read_text().splitlines()]
    lines = [line for line in lines_of("solvers") if "sizes)" in line]
    assert len(lines) == 10
    for line in lines:
        assert line in docs, line


def test_the_median_comes_with_its_range():
    assert spread([3.0, 1.0, 2.5]) == "2.5 (1–3)"
    assert spread([2.0, 2.0], ".1f") == "2.0"  # exactly equal
    assert spread([128.0, 131.0]) == "130 (130–130)"
    assert spread([2.01, 2.02], ".1f") == "2.0 (2.0–2.0)"  # equal as written only


def test_an_exponent_is_no_better_than_its_repeats():
    """N^2 exactly: repeats off by ± 10 % at both of two sizes make the error
    √2 ln(1.1/0.9)/2 / ln 10; the same on a line of equal repeats is 0, and a kink enlarges it."""
    sizes, off = [100, 1000], np.array([0.9, 1.0, 1.1])
    slope, error = exponent(sizes, [n**2 * off for n in sizes])
    assert slope == pytest.approx(2)
    assert error == pytest.approx(np.sqrt(2) * np.log(1.1 / 0.9) / 2 / np.log(10))
    assert exponent(sizes, [[n**2] * 2 for n in sizes])[1] == 0
    bent = [[1.0], [100.0], [2e4]]
    assert exponent([1, 10, 100], bent)[1] > 0.05


def test_numbering_and_blocks_are_timed_on_the_same_packing(monkeypatch):
    monkeypatch.setattr(numbering, "relax", lambda *_, **__: packing(grains=48, delta=1e-3))
    monkeypatch.setattr(numbering, "BASE", 48)
    spent = numbering.compute(2, repeats=2)
    assert all(len(times) == 2 and times.min() > 0 for times in spent.values())
    assert numbering.ONE_PIECE in numbering.text(spent)
    states = [numbering.state(packing(grains=48, delta=1e-3), name, 2)
              for name in (numbering.STRIPS, numbering.RANDOM)]  # fmt: skip
    assert not np.array_equal(states[0].positions, states[1].positions)
    np.testing.assert_array_equal(*(np.sort(s.positions[:, 0]) for s in states))


def test_single_precision_makes_noise_and_doubles_do_not():
    """Δ = 1e-4: forces at rest change by 1e-6 to 1 p in float32, by less in float64."""
    table = precision.compute(36, [1e-4], [1, 2])
    single = table["precision"] == "float32"
    assert table["noise"][~single].max() < 1e-6 < table["noise"][single].min()
    assert table["noise"][single].max() < 1
    assert "float32 | 2/2" in precision.text(table)
    gone = table.copy()
    gone["rest"][single] = False
    assert "float32 | 0/2" in precision.text(gone)


def test_the_polish_is_a_share_of_the_whole():
    table = polish_cost.compute([36], [1, 2])
    assert table["tries"].min() >= 1
    assert min(table["polish"].min(), table["motion"].min()) > 0
    assert "| 36 | 2 |" in polish_cost.text(table)


def test_continued_and_integrated_packings_are_compared():
    """Different packings (the control), each with a Z of its own."""
    with ThreadPoolExecutor(1) as pool:
        found = continuation.compute(pool, 36, [1, 2])
    assert found.shape == (2, 2, len(continuation.HEADS))
    assert not np.array_equal(found[:, 0], found[:, 1])
    assert "off by" in continuation.text(found)


def test_growth_of_a_ramp_is_told_for_every_rate():
    """The default rate is what `ramp` does by itself, and another rate does something else."""
    with ThreadPoolExecutor(1) as pool:
        found = ramps.rates(pool, 36, [1, 2])
    assert set(found) == set(ramps.RATES)
    assert not np.array_equal(found[0.03], found[0.1])
    assert ramps.text_of_rates(found).count("±") == 5


def test_ensembles_are_as_efficient_as_the_clock_says():
    """Shares of the time between 0 and 1, of two packings twice."""
    gain, busy = ensembles.efficiency(2, 30, 2)
    assert len(gain) == len(busy) == 2
    assert 0 < min(busy) <= max(busy) <= 1
    said = ensembles.text({4: ([0.9, 1.0], [0.8, 0.9])})
    assert "Ensembles of 4" in said
    assert "efficiency 0.95 (0.90–1.00), share of time at work 0.85 (0.80–0.90)" in said


def test_sizes_are_told_with_their_ranges(monkeypatch):
    """Every time and ratio has a range; memory too small to be seen is left out."""
    monkeypatch.setattr(size, "relax", lambda *_, **__: packing(grains=48, delta=1e-3))
    monkeypatch.setattr(size, "FRESH", 1)
    said = size.text(size.compute((1, 2)))
    rows = [line for line in said.splitlines() if line.startswith(("| numba", "| numpy"))]
    assert all(line.count("–") == 2 for line in rows[:6])
    assert "| resident bytes per grain |  |" in said
