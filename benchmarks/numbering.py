"""What a step costs when memory is not laid out well: numbering of grains, blocks of pairs.

A packing at rest of 1000 grains, and the same tiled 10 × 10, numbered along strips as `relax` does
from 2000 grains on, or at random as they are drawn; and the NumPy kernel with all its pairs in one
piece.  All cases are interleaved.  `Large over small` is the cost of a grain at 1e5 over that at
1e3; `over strips` is the time over that of the same backend along strips in blocks, at 1e5.
"""

from __future__ import annotations

import time
from importlib.util import find_spec
from unittest.mock import patch

import numpy as np

from benchmarks.size import BASE, DELTA
from dem import ContactLaw, Drive, Packing, Scene, State, relax, step
from dem.motion.kernels.disks_numpy import BLOCK
from dem.protocols.loose_gas import along_strips
from scaling import ContactNetwork, tiled
from studies.error_bars import spread

REPEATS = 5
STRIPS, RANDOM, ONE_PIECE = "along strips", "at random", "along strips, pairs in one piece"
Case = tuple[str, str, int]


def cases(copies: int) -> list[Case]:
    """(backend, case, tiles a side)."""
    names = [("numba", STRIPS), ("numba", RANDOM)] if find_spec("numba") else []
    names += [("numpy", STRIPS), ("numpy", RANDOM), ("numpy", ONE_PIECE)]
    return [(backend, name, n) for backend, name in names for n in (1, copies)]


def state(packing: Packing, name: str, n: int) -> State:
    """The tiled packing, its grains numbered so."""
    network = tiled(ContactNetwork.from_packing(packing), n)
    x = network.positions
    order = np.random.default_rng(1).permutation(len(x)) if name == RANDOM else along_strips(x)
    return State(x[order], network.radii[order], cell=network.cell)


def compute(copies: int, repeats: int = REPEATS) -> dict[Case, np.ndarray]:
    """µs per grain and step of each repeat."""
    packing = relax(Scene(BASE, DELTA), 1, progress=False)
    states = {case: state(packing, *case[1:]) for case in cases(copies)}
    spent: dict[Case, list[float]] = {case: [] for case in states}
    for repeat in range(repeats + 1):  # the first is thrown away
        for case, moving in states.items():
            steps = max(20, 200_000 // len(moving.radii))
            with patch(
                "dem.motion.kernels.disks_numpy.BLOCK", 10**9 if case[1] == ONE_PIECE else BLOCK
            ):
                begin = time.process_time()
                step(
                    moving, ContactLaw(), 0.05, drive=Drive(DELTA**0.5, DELTA), steps=steps,
                    skin=0.2, backend=case[0],
                )  # fmt: skip
            if repeat:
                spent[case].append((time.process_time() - begin) / steps / len(moving.radii) * 1e6)
    return {case: np.array(times) for case, times in spent.items()}


def text(spent: dict[Case, np.ndarray]) -> str:
    """One line per backend and numbering."""
    small, large = sorted({n for _, _, n in spent})
    few, many = BASE * small**2, BASE * large**2
    lines = [
        f"µs per grain and step, median (min–max) of {REPEATS}; ratios within a repeat.", "",
        f"| backend | grains numbered | N = {few} | N = {many} | large over small | over strips |",
        "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for backend, name, n in spent:
        if n == small:
            one, other = spent[backend, name, small], spent[backend, name, large]
            ratio = other / spent[backend, STRIPS, large]
            lines.append(
                f"| {backend} | {name} | {spread(one, '.4f')} | {spread(other, '.4f')} "
                f"| {spread(other / one, '.2f')} | {spread(ratio, '.2f')} |"
            )
    return "\n".join(lines)
