"""The fuzzer of readers finds nothing here, and finds what it is for where it is."""

from __future__ import annotations

import time

import numpy as np
import pytest

from packing.files.problem import FileProblem
from packing.measurement import Measurement
from packing.note import Note
from packing.reading import read
from tests.fuzz.readers import (
    BARE,
    DAMAGES,
    FAULTS,
    HALF,
    HUNG,
    MEASUREMENT,
    PACKING,
    REFUSED,
    fuzz,
    main,
    put,
    whole_samples,
)


def test_damaged_files_are_refused_or_read_whole():
    counts, faults = fuzz(400, seed=11)
    assert faults == []
    assert counts[REFUSED] + counts[PACKING] + counts[MEASUREMENT] == 400
    assert min(counts[REFUSED], counts[PACKING], counts[MEASUREMENT]) > 20


def test_every_damage_of_every_sample_is_drawn(tmp_path):
    samples = whole_samples()
    drawn = [put(tmp_path, samples, 1, k) for k in range(500)]
    assert {damage.split()[0] for _, damage in drawn} == {d.__name__ for d in DAMAGES}
    assert {whole.name for whole, _ in drawn} == {whole.name for whole in samples}


def note(name, file):
    return FileProblem(Note("error", name, "why", file))


@pytest.mark.parametrize("error", [ValueError("p.csv"), KeyError("x"), note("cut-short", "other")])
def test_errors_that_name_nothing_are_caught(error):
    def failing(path, **options):
        raise error

    assert fuzz(4, seed=1, reading=failing)[0] == {BARE: 4}


def test_half_a_packing_is_caught():
    """A reader that keeps half of the grains, or half of the contacts."""

    def grains(path, **options):
        found = read(path, **options)
        return Measurement(found.positions[::2])

    def contacts(path, **options):
        found = read(path, **options)
        return Measurement(found.positions, walls=found.walls, pairs=found.pairs[::-2][::-1])

    for reading in (grains, contacts):
        counts, faults = fuzz(80, seed=1, reading=reading)
        assert counts[HALF] > 5
        assert len(faults) >= counts[HALF]


def test_a_reader_that_hangs_is_caught():
    def hanging(path, **options):
        try:
            time.sleep(60)
        except Exception:  # an alarm that is an Exception would end here
            return None

    assert fuzz(2, seed=1, reading=hanging, limit=0.05)[0] == {HUNG: 2}


def test_one_line_of_counts(capsys, monkeypatch):
    monkeypatch.setattr("tests.fuzz.readers.resource.setrlimit", lambda *a: None)
    assert main(["--inputs", "22", "--seed", "3"]) == 0
    line = capsys.readouterr().out.strip()
    assert line.startswith("22 damaged files: ")
    assert all(f"0 {kind}" in line for kind in FAULTS)
    numbers = [int(word) for word in line.split() if word.isdigit()]
    assert np.sum(numbers[1:]) == 22
