"""The API fuzzer: calls of the public functions with valid and odd arguments, judged.

    python -m tests.fuzz.api --inputs 100000 --seed 0

Input k of a seed is always the same; `--only k` repeats it and shows the traceback. Inputs run in
a process of their own with a limit on its memory, so that one that hangs inside a library, or
kills the process, costs that input alone. Exit 1 if there are faults.
"""

from __future__ import annotations

import argparse
import multiprocessing
import re
import resource
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import chdir
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from packing.arguments.numbers import shown
from tests.fuzz.calls import Call, weighted
from tests.fuzz.dem_calls import DEM
from tests.fuzz.exact_calls import EXACT
from tests.fuzz.samples import problem, samples
from tests.fuzz.scaling_calls import SCALING
from tests.fuzz.verdict import GOOD, judged

TABLE: tuple[Call, ...] = (*SCALING, *DEM, *EXACT)
MEMORY = 2 * 1024**3
"""Bytes that a call may take beyond what is in use when the run starts."""
_ODD = 0.25
_GRACE = 15.0
"""Seconds beyond its limit after which a call that no alarm stops is killed with its process."""
Verdict = tuple[int, str, str, str, str]
"""Number of the input, function, replaced arguments, verdict, detail."""


def drawn(
    seed: int, number: int, table: tuple[Call, ...] = TABLE
) -> tuple[Call, dict[str, Any], dict[str, Any]]:
    """(call, arguments, the replaced ones) of input `number` of a seed."""
    rng = np.random.default_rng([seed, number])
    call = table[int(rng.choice(**weighted(table)))]
    return call, *call.draw(rng, _ODD)


def examined(seed: int, number: int, table: tuple[Call, ...] = TABLE) -> Verdict:
    """The verdict on input `number`, in this process."""
    call, arguments, replaced = drawn(seed, number, table)
    odd = ", ".join(f"{name}={shown(value)}" for name, value in replaced.items())
    return number, call.name, odd, *judged(call.function, arguments, call.seconds, call.allowed)


def _work(pipe: Connection, seed: int, first: int, end: int, table: tuple[Call, ...]) -> None:
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))
    with TemporaryDirectory() as folder, chdir(folder):  # odd paths are written to
        for number in range(first, end):
            pipe.send(examined(seed, number, table))
    pipe.close()


def verdicts(
    seed: int, inputs: int, first: int = 0, table: tuple[Call, ...] = TABLE
) -> Iterator[Verdict]:
    """The verdicts on inputs first ... first + inputs - 1, each in a process that may die."""
    samples(), problem()  # made once, before processes are forked
    fork = multiprocessing.get_context("fork")
    number, end = first, first + inputs
    longest = max(call.seconds for call in table) + _GRACE
    while number < end:
        ours, theirs = fork.Pipe(duplex=False)
        worker = fork.Process(target=_work, args=(theirs, seed, number, end, table))
        worker.start()
        theirs.close()
        fate = ""
        while number < end and not fate:
            try:
                if ours.poll(longest):
                    yield ours.recv()
                    number += 1
                else:
                    fate = "hang"
            except EOFError:
                fate = "killed"
        if fate:
            worker.kill()
            call, _, replaced = drawn(seed, number, table)
            odd = ", ".join(f"{name}={shown(value)}" for name, value in replaced.items())
            yield number, call.name, odd, fate, "no answer of its process"
            number += 1
        worker.join()


def faults_of(found: list[Verdict]) -> dict[tuple[str, str, str], list[Verdict]]:
    """Distinct faults: by function, verdict and the start of what was said."""
    distinct: dict[tuple[str, str, str], list[Verdict]] = {}
    for each in found:
        _, name, _, verdict, detail = each
        if verdict not in GOOD:
            distinct.setdefault((name, verdict, _kind(detail)), []).append(each)
    return distinct


def _kind(detail: str) -> str:
    """What was said without what differs from value to value: quoted words and numbers."""
    return re.sub(r"'[^']*' object|[\d.]+", "_", detail)[:50]


def summary(found: list[Verdict]) -> str:
    """Counts of the verdicts, and the distinct faults with the smallest example of each."""
    counts = Counter(each[3] for each in found)
    lines = [f"{len(found)} inputs: " + ", ".join(f"{n} {v}" for v, n in counts.most_common())]
    for (name, verdict, _), group in sorted(faults_of(found).items()):
        number, _, odd, _, detail = min(group, key=lambda each: each[2].count("="))
        lines.append(f"  {len(group):5d} × {name}({odd}) [input {number}] {verdict}: {detail}")
    return "\n".join(lines)


def main(argv: list[str] | None = None) -> int:
    """Run from the command line; 1 if there are faults."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.api", description=__doc__)
    parser.add_argument("--inputs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--only", type=int, help="repeat this input, with its traceback")
    parser.add_argument("--function", help="only calls whose name contains this")
    options = parser.parse_args(argv)
    table = tuple(c for c in TABLE if not options.function or options.function in c.name)
    if not table:
        parser.error(f"no function contains {options.function!r}")
    if options.only is not None:
        call, arguments, replaced = drawn(options.seed, options.only, table)
        print(call.name, {name: shown(value) for name, value in arguments.items()})
        print("replaced:", ", ".join(replaced) or "nothing")
        try:
            print("returned", shown(call.function(**arguments)))
        except Exception:
            traceback.print_exc()
        return int(examined(options.seed, options.only, table)[3] not in GOOD)
    start = time.perf_counter()
    found = list(verdicts(options.seed, options.inputs, options.first, table))
    print(summary(found))
    print(f"seed {options.seed}, {time.perf_counter() - start:.0f} s")
    return int(bool(faults_of(found)))


if __name__ == "__main__":
    sys.exit(main())
