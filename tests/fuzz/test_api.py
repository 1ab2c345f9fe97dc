"""A short run of the API fuzzer, and that it catches what it is there to catch."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tests.fuzz.api import TABLE, drawn, examined, faults_of, main, verdicts
from tests.fuzz.calls import Call
from tests.fuzz.verdict import GOOD, judged, names_something, not_finite

QUICK = [call for call in TABLE if call.weight > 0.05 or not call.name.startswith("symbolic")]
"""All but exact algebra that takes seconds a call: the long run has it."""


@pytest.mark.parametrize("call", QUICK, ids=[call.name for call in QUICK])
def test_right_or_refused(call):
    """A few calls of each function: finite, or refused by the name of an argument."""
    count = 4 if call.weight >= 0.3 else 1
    found = [examined(7, number, (call,)) for number in range(count)]
    assert not faults_of(found), found


@pytest.mark.parametrize("call", TABLE, ids=[call.name for call in TABLE])
def test_valid_arguments_are_no_refusals(call):
    """Of the arguments as they are drawn, before any is replaced, some are taken."""
    if call.weight < 0.15:
        pytest.skip("takes long")
    for number in range(12):
        arguments = call.valid(np.random.default_rng(number))
        verdict, detail = judged(call.function, arguments, call.seconds, call.allowed)
        assert verdict in GOOD, detail
        if verdict == "finite" or call.allowed:
            return
    raise AssertionError(f"{call.name} refuses all valid arguments")


def leaks(stiffness):
    return 1.0 / stiffness


def mumbles(stiffness):
    if not stiffness == 1.0:
        raise ValueError("bad input")
    return stiffness


def returns_nan(stiffness):
    return {"forces": np.array([1.0, np.nan])}


def sleeps(stiffness):
    time.sleep(5)


@pytest.mark.parametrize(
    ("function", "verdict"),
    [(leaks, "leaked"), (mumbles, "names nothing"), (returns_nan, "not finite"), (sleeps, "hang")],
)
def test_each_kind_of_fault_is_caught(function, verdict):
    """Negative controls: a TypeError, a ValueError without a name, a NaN and a hang."""
    assert judged(function, {"stiffness": "1"}, 0.1)[0] == verdict


def test_good_endings_are_none():
    def refuses(stiffness):
        raise ValueError(f"stiffness = {stiffness!r} is not a number")

    def gives_up(stiffness):
        raise RuntimeError("did not converge in 3 steps")

    assert judged(refuses, {"stiffness": "1"})[0] == "refused"
    assert judged(gives_up, {"stiffness": "1"})[0] == "broke off"
    assert judged(lambda stiffness: (1, None, "a", [2.0]), {"stiffness": 1})[0] == "finite"
    assert names_something("grain 3 has no contact", {})
    assert not names_something("operands could not be broadcast together", {"xi": 1})
    assert not_finite({"a": (1.0, [np.inf])}) == "result['a'][1][0] = inf"


def test_inputs_are_reproducible():
    for number in range(30):
        first, second = drawn(0, number), drawn(0, number)
        assert first[0] is second[0]
        assert list(first[2]) == list(second[2])


def dies(stiffness):
    import os

    os._exit(1)


def test_an_input_that_kills_its_process_costs_only_itself():
    """Three inputs, each ends its process: three verdicts, in order."""
    table = (Call("dies", dies, lambda rng: {"stiffness": 1.0}),)
    found = list(verdicts(0, 3, table=table))
    assert [(n, verdict) for n, _, _, verdict, _ in found] == [(0, "killed"), (1, "killed"),
                                                               (2, "killed")]  # fmt: skip


def test_the_command_reports_counts(capsys):
    assert main(["--inputs", "20", "--function", "two_sum"]) == 0
    assert "20 inputs: " in capsys.readouterr().out
