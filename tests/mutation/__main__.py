"""``python -m tests.mutation [--only NAME ...]``: exit code 1 if a mutation goes unnoticed."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from tests.mutation.dem import DEM
from tests.mutation.mutation import Mutation, check, copy_of, is_noticed, outcome
from tests.mutation.scaling import SCALING
from tests.mutation.symbolic import SYMBOLIC

ROOT = Path(__file__).resolve().parents[2]
ALL = (*SCALING, *DEM, *SYMBOLIC)


def run(mutations: Sequence[Mutation], root: Path) -> list[str]:
    """Names of those that no test noticed and no reason excuses; a line on each is printed.

    ValueError: the list has lost touch with the code. RuntimeError: the tests named do not pass
    on the code as it is.
    """
    check(mutations, root)
    begin, survivors = time.perf_counter(), []
    with copy_of(root) as tree:
        tests = sorted({test for mutation in mutations for test in mutation.tests})
        if code := outcome(tree, tests):
            raise RuntimeError(f"pytest ends with {code} on the code as it is: {' '.join(tests)}")
        for mutation in mutations:
            noticed = is_noticed(mutation, tree)
            word = "killed" if noticed else f"SURVIVED {mutation.equivalent}".rstrip()
            print(f"{time.perf_counter() - begin:5.0f} s  {mutation.name}: {word}", flush=True)
            if not noticed and not mutation.equivalent:
                survivors.append(mutation.name)
            if noticed and mutation.equivalent:
                survivors.append(f"{mutation.name} (noticed, though said to be equivalent)")
    return survivors


def main(words: Sequence[str] | None = None) -> int:
    """Run the mutations named, or all."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="names, or beginnings of names")
    asked = parser.parse_args(words).only
    chosen = [m for m in ALL if asked is None or m.name.startswith(tuple(asked))]
    for word in asked or ():
        if not any(m.name.startswith(word) for m in ALL):
            known = ", ".join(m.name for m in ALL)
            parser.error(f"{word}: no such mutation; there are {known}")
    survivors = run(chosen, ROOT)
    print(f"{len(chosen)} mutations, unnoticed: {', '.join(survivors) or 'none'}")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
