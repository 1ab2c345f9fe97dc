"""The DEM step against the same step in C (``step.c``), interleaved in one run.

    python -m benchmarks.other_codes.c_step [grains] [repeats]

The same packing at rest (Δ = 1e-3), the same pairs in the same order, plain doubles, one thread;
compiled here by ``gcc -O3 -march=native``.  C neither checks its list nor renews it, and it is
held to the same end: where its grains are after all steps is compared with where ours are.  The
ratio says what of a step is the limit of a compiled loop, and what is ours.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.step_cost import at_rest
from dem import ContactLaw, Drive, Packing, Scene, State, relax, step
from dem.motion.neighbours import find_neighbours
from packing.arguments.arrays import Floats
from studies.command_line import counts
from studies.error_bars import spread

DELTA, DT, SKIN, STEPS, REPEATS = 1e-3, 0.05, 0.2, 300, 9
DRIVE = Drive(drag=DELTA**0.5, pressure=DELTA)
SOURCE = Path(__file__).parent / "step.c"


class Compiled:
    """The loop of ``step.c`` on a packing, with arrays of its own."""

    def __init__(self, library: ctypes.CDLL, state: State) -> None:
        near = find_neighbours(state, SKIN)
        self.library, self.mass = library, state.masses
        self.arrays = {
            "z": state.positions.copy(), "v": state.velocities.copy(),
            "s": state.radii * state.spins, "per_mass": 1 / self.mass,
        }  # fmt: skip
        self.pairs = [np.ascontiguousarray(k, np.uint32) for k in near.columns]
        self.lists = [near.shift, near.sigma, near.elongation.copy(), near.origin]
        self.area = float(np.prod(near.sides))
        self.inertia = float(self.mass.sum()) * (2 * float(state.radii.mean())) ** 2
        self.forces = np.zeros((len(self.mass), 2)), np.zeros(len(self.mass))
        self.cell, self.far = np.array([1.0, 0.0]), np.zeros(1)

    def advance(self, steps: int) -> None:
        """So many time steps, whole ones."""
        law, real, whole = ContactLaw(), ctypes.c_double, ctypes.c_int64
        self.library.advance(
            whole(len(self.mass)), whole(len(self.pairs[0])), *map(_at, self.arrays.values()),
            real(self.inertia), real(self.area), *map(_at, self.pairs), *map(_at, self.lists),
            *map(real, (law.stiffness, law.tangential, law.friction)),
            *map(real, (DRIVE.drag, DELTA, DT)), whole(steps),
            *map(_at, self.forces), _at(self.cell), _at(self.far),
        )  # fmt: skip
        if self.far[0] > (SKIN / 2) ** 2:
            raise RuntimeError("a grain has left the list: the comparison holds no longer")


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def compiled(folder: str) -> ctypes.CDLL:
    """``step.c`` as a library."""
    library = f"{folder}/step.so"
    command = [
        "gcc",
        "-O3",
        "-march=native",
        "-shared",
        "-fPIC",
        "-o",
        library,
        str(SOURCE),
        "-lm",
    ]
    subprocess.run(command, check=True)
    return ctypes.CDLL(library)


def pushed(packing: Packing) -> State:
    """The packing at rest, its grains given speeds as they have on the way to rest."""
    state = at_rest(packing)
    state.velocities += 1e-4 * np.random.default_rng(1).normal(size=state.velocities.shape)
    return state


def compute(grains: int, repeats: int = REPEATS, backend: str = "numba") -> list[list[float]]:
    """Nanoseconds per grain and step of ours and of C's, interleaved.

    RuntimeError if they do not end in the same place.
    """
    packing = relax(Scene(grains, DELTA), 1)
    spent: list[list[float]] = [[], []]
    with tempfile.TemporaryDirectory() as folder:
        library = compiled(folder)
        for repeat in range(repeats + 1):  # the first is thrown away
            ours, theirs = pushed(packing), Compiled(library, pushed(packing))
            for times, advance in zip(spent, (march(ours, backend), theirs.advance), strict=True):
                advance(1)  # the list is found
                begin = time.process_time()
                advance(STEPS)
                if repeat:
                    times.append((time.process_time() - begin) / STEPS / grains * 1e9)
            _same(ours.positions, theirs.arrays["z"])
    return spent


def march(state: State, backend: str) -> Callable[[int], None]:
    """So many of our time steps."""

    def advance(steps: int) -> None:
        step(state, ContactLaw(), DT, drive=DRIVE, steps=steps, skin=SKIN, backend=backend)

    return advance


def _same(ours: Floats, theirs: Floats) -> None:
    """C makes whole steps, ours half kicks at both ends: positions differ by ~ dt² |a|/2."""
    apart = float(np.abs(ours - theirs).max())
    if not apart < 1e-5:
        raise RuntimeError(f"C ends {apart:.2g} ⟨σ⟩ from where ours does: not the same step")


def text(found: dict[int, list[list[float]]]) -> str:
    """One table, in Markdown."""
    lines = [
        f"Δ = {DELTA:g}, {STEPS} steps, median (min–max) of {REPEATS}",
        "",
        "| N | Numba, ns per grain and step | C | Numba over C, of the same repeat |",
        "|---|---|---|---|",
    ]
    for grains, (ours, theirs) in found.items():
        ratio = spread(np.divide(ours, theirs), ".2f")
        lines.append(f"| {grains} | {spread(ours, '.1f')} | {spread(theirs, '.1f')} | {ratio} |")
    return "\n".join(lines)


if __name__ == "__main__":
    size, times = counts("benchmarks.other_codes.c_step", __doc__, grains=1000, repeats=REPEATS)
    print(text({size: compute(size, times)}))
