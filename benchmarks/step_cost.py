"""What a time step costs, and what each piece of physics adds to it.

Both backends on packings of N = 1000 at rest at Δ = 1e-3, all cases interleaved in one run, median
(min–max); the ratios are what to read.  Friction 0 has no history, no rotation, no torques, and a
packing of its own (that of friction would flow without it, and rebuild its list), and so have
elastic spheres; a fixed cell has no pressure control.  In this model grains turn because friction
turns them and friction remembers: a scene has both or neither.  What rotation alone costs is timed
piece by piece on the NumPy kernel (surface speeds of a pair, sum of torques, kick of the spins);
the rest of what friction adds is its history (slip, spring, slider).  Numba's single loop cannot
be taken apart like that.

    python -m benchmarks.step_cost
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from dem import ContactLaw, Drive, History, Packing, Scene, State, relax, step
from dem.motion.kernels.disks_numpy import contact_forces, kick
from dem.motion.kernels.motion import Motion
from dem.motion.neighbours import find_neighbours
from packing.contact_law import Hertz
from studies.command_line import counts
from studies.error_bars import spread

DELTA, GRAINS, STEPS, REPEATS = 1e-3, 1000, 300, 9
PRESSED, FIXED = Drive(drag=DELTA**0.5, pressure=DELTA), Drive(drag=DELTA**0.5)
REFERENCE = "friction, pressure control"
CASES = {
    REFERENCE: (ContactLaw(), PRESSED, "float64"),
    "friction, fixed cell": (ContactLaw(), FIXED, "float64"),
    "frictionless, pressure control": (ContactLaw(friction=0.0), PRESSED, "float64"),
    "frictionless, fixed cell": (ContactLaw(friction=0.0), FIXED, "float64"),
    "friction, contact dashpot": (ContactLaw(dashpot=0.1), PRESSED, "float64"),
    "friction, float32": (ContactLaw(), PRESSED, "float32"),
    "elastic spheres, pressure control": (
        ContactLaw(contact=Hertz()), Drive(DELTA**0.75, DELTA**1.5), "float64",
    ),
}  # fmt: skip
SCENES = {
    "rough": Scene(GRAINS, DELTA), "smooth": Scene(GRAINS, DELTA, friction=0.0),
    "spheres": Scene(GRAINS, DELTA, contact="hertz"),
}  # fmt: skip


def microseconds(work: Callable[[], object], times: int) -> float:
    """Processor time of one call."""
    start = time.process_time()
    for _ in range(times):
        work()
    return (time.process_time() - start) / times * 1e6


def at_rest(packing: Packing) -> State:
    """The packing with its springs."""
    k_t = packing.law.tangential_stiffness(packing.overlaps)
    history = History(packing.pairs, packing.images, packing.tangential_forces / k_t)
    return State(packing.positions, packing.radii, cell=packing.cell, history=history)


def scene_of(law: ContactLaw) -> str:
    """The name of the scene whose packing the case moves."""
    if law.linear is None:
        return "spheres"
    return "rough" if law.friction else "smooth"


def steps(packings: dict[str, Packing], backends: list[str]) -> dict[str, dict[str, list[float]]]:
    """Time per step of every backend and case, several times over, all interleaved."""
    states = {
        (backend, name): at_rest(packings[scene_of(law)])
        for backend in backends
        for name, (law, _, _) in CASES.items()
    }
    spent: dict[str, dict[str, list[float]]] = {b: {name: [] for name in CASES} for b in backends}
    for repeat in range(REPEATS + 1):  # the first is thrown away
        for (backend, name), state in states.items():
            law, drive, precision = CASES[name]
            start = time.process_time()
            step(
                state, law, 0.05, drive=drive, steps=STEPS, skin=0.2, backend=backend,
                precision=precision,
            )  # fmt: skip
            if repeat:
                spent[backend][name].append((time.process_time() - start) / STEPS * 1e6)
    return spent


def rotation(state: State) -> list[float]:
    """Time per step that the NumPy kernel spends on rotation, several times over."""
    near = find_neighbours(state, 0.2)
    i, j = near.columns
    motion = Motion(
        state.positions.view(complex)[:, 0].copy(), state.velocities.view(complex)[:, 0].copy(),
        state.radii * state.spins, state.masses, float(state.masses.sum()),
        float(np.prod(near.sides)), 1.0, 0.0,
    )  # fmt: skip
    forces = contact_forces(motion, near, ContactLaw(), 0.0)
    torques = np.zeros(len(i))

    def kicked(rotates: bool) -> Callable[[], object]:
        return lambda: kick(motion, forces, PRESSED, 0.0, 0.0, rotates)

    return [
        microseconds(lambda: motion.s[i] + motion.s[j], STEPS)
        + microseconds(lambda: near.adjacency @ torques, STEPS)
        + microseconds(kicked(True), STEPS)
        - microseconds(kicked(False), STEPS)
        for _ in range(REPEATS)
    ]


def main() -> None:
    """Print one table, in Markdown."""
    packings = {name: relax(scene, 1) for name, scene in SCENES.items()}
    backends = ["numpy"] + ["numba"] * (find_spec("numba") is not None)
    rough, smooth, spheres = (len(packings[name].pairs) for name in SCENES)
    print(
        f"N = {GRAINS}, {rough} contacts ({smooth} frictionless, {spheres} of elastic spheres): "
        f"median (min–max) of {REPEATS}"
    )
    print("\n| backend | physics | µs per step | over the first, of the same repeat |")
    print("|---|---|---|---|")

    def show(backend: str, name: str, times: list[float], reference: list[float]) -> None:
        ratio = spread(np.divide(times, reference), ".2f")
        print(f"| {backend} | {name} | {spread(times, '.1f')} | {ratio} |")

    found = steps(packings, backends)
    for backend, spent in found.items():
        reference = spent[REFERENCE]
        for name, times in spent.items():
            show(backend, name, times, reference)
        if backend == "numpy":
            turning = rotation(at_rest(packings["rough"]))
            show(backend, "of friction: rotation", turning, reference)
            rest = np.subtract(reference, spent["frictionless, pressure control"])
            show(backend, "of friction: history", list(rest - turning), reference)
    if "numba" in found:
        times = np.divide(found["numpy"][REFERENCE], found["numba"][REFERENCE])
        print(f"\n{REFERENCE}: NumPy over Numba, of the same repeat: {spread(times, '.2f')}")


if __name__ == "__main__":
    counts("benchmarks.step_cost", __doc__)
    main()
