"""The fuzzer of files finds nothing here, and finds what it is for where it is."""

from __future__ import annotations

import time

import pytest

import packing.files.npz as packing_file
from tests.fuzz.files import BARE, DIFFERENT, FAULTS, HUNG, IDENTICAL, REFUSED, fuzz, main


def test_damaged_files_are_refused_or_as_they_were():
    counts, faults = fuzz(300, seed=1)
    assert faults == []
    assert counts[REFUSED] + counts[IDENTICAL] == 300
    assert min(counts[REFUSED], counts[IDENTICAL]) > 0


def test_a_loader_without_checksum_is_caught(monkeypatch):
    def trusting(path, record):
        del record["sha256"], record["arrays"]

    monkeypatch.setattr(packing_file, "_check_whole", trusting)
    counts, faults = fuzz(300, seed=1)
    assert counts[DIFFERENT] > 0
    assert any("packed_again" in fault for fault in faults)


def test_a_loader_that_trusts_the_directory_is_caught(monkeypatch):
    """As before there was a checksum: entries that a damaged entry swallows are not missed."""
    monkeypatch.setattr("packing.files.archive._check_places", lambda *a: None)
    _, faults = fuzz(300, seed=1)
    assert any("format 2, entry_swallowed" in fault for fault in faults)


@pytest.mark.parametrize(
    ("error", "kind"),
    [(TypeError("p.npz"), BARE), (ValueError("no name"), BARE), (KeyError("damaged.npz"), BARE)],
)
def test_errors_that_name_nothing_are_caught(error, kind):
    def failing(path):
        raise error

    counts, faults = fuzz(4, seed=1, load=failing)
    assert counts == {kind: 4}
    assert len(faults) == 4


def test_a_loader_that_hangs_is_caught():
    def hanging(path):
        try:
            time.sleep(60)
        except Exception:  # an alarm that is an Exception would end here
            return None

    assert fuzz(2, seed=1, load=hanging, limit=0.05)[0] == {HUNG: 2}


def test_one_line_of_counts(capsys, monkeypatch):
    assert main(["--inputs", "4"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert all(kind in line for kind in (REFUSED, IDENTICAL, *FAULTS))
    monkeypatch.setattr("packing.files.npz._check_whole", lambda *a: 1 / 0)
    assert main(["--inputs", "40"]) == 1
    assert BARE in capsys.readouterr().out.splitlines()[0]
    with pytest.raises(SystemExit):
        main(["--inputs", "0"])
