"""What is told of the mean stress of a periodic cell, and its rows: linear in the forces.

    A σ_ab = Σ_e r_e n_a (f_n n - f_t t)_b ,     2 A p = Σ_e f_n r_e

Where distances are no data the rows need none: r n are then the lattice vectors H that contacts
cross, for forces that balance: A σ_ab = Σ_e H_a (f_n n - f_t t)_b, the force across the sides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import positive_number, shown
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.told.datum import Datum, datum

COMPONENTS = {"xx": (0, 0), "xy": (0, 1), "yx": (1, 0), "yy": (1, 1)}
"""Of σ_ab: a the direction of the normal of a side, b that of the force on it."""


@dataclass(frozen=True)
class MeanStress:
    """Pressure, None if nobody knows or nobody said, and components by name."""

    pressure: Datum | None = None
    components: tuple[tuple[str, Datum], ...] = ()

    @property
    def data(self) -> tuple[tuple[str, Datum], ...]:
        """All, the pressure as "p"."""
        p = () if self.pressure is None else (("p", self.pressure),)
        return (*p, *self.components)

    @property
    def noisy(self) -> int:
        """How many have an error bar."""
        return sum(not told.exact for _, told in self.data)

    @property
    def fixes_trace(self) -> bool:
        """Whether Σ f_n r is known exactly."""
        exact = {name for name, told in self.data if told.exact}
        return "p" in exact or {"xx", "yy"} <= exact

    @property
    def likely_pressure(self) -> float | None:
        """The pressure told, or that of xx and yy, or of the one of them that is."""
        if self.pressure is not None:
            return self.pressure.value
        sides = [told.value for name, told in self.components if name in ("xx", "yy")]
        return float(np.mean(sides)) if sides else None


NOTHING = MeanStress()
"""Nothing told."""


def mean_stress(pressure: Any, stress: Any) -> MeanStress:
    """What the options `pressure` and `stress` say; None says nothing.

    ValueError: no number, a pressure that is not positive, an unknown component, or one told
    twice over.
    """
    p = None if pressure is None else datum("pressure", pressure, positive_number)
    if stress is None:
        return MeanStress(p)
    if isinstance(stress, Mapping) and "p" in stress:
        if pressure is not None:
            raise ValueError("the pressure is told twice: pressure, and stress['p']")
        p = datum("stress['p']", stress["p"], positive_number)
    if not isinstance(stress, Mapping):
        raise ValueError(
            f"stress = {shown(stress)}: components by name are needed, "
            '{"xx": 1.0, "xy": (0.0, 0.01)}'
        )
    found = []
    for name, told in stress.items():
        if name == "p":
            continue
        if name not in COMPONENTS:
            raise ValueError(
                f"stress has a component {shown(name)}: there are p, {', '.join(COMPONENTS)}"
            )
        one = datum(f"stress[{name!r}]", told)
        if one is not None:
            found.append((name, one))
    made = MeanStress(p, tuple(found))
    _refuse_twice(made)
    return made


def _refuse_twice(told: MeanStress) -> None:
    exact = {name for name, one in told.data if one.exact}
    if {"p", "xx", "yy"} <= exact:
        raise ValueError("pressure and the components xx, yy are all exact: leave one of them out")
    if {"xy", "yx"} <= exact:
        raise ValueError(
            "stress xy and yx are both exact: they are one number where moments balance; tell one"
        )


def stress_rows(equation: ForceEquation, told: MeanStress, distances: bool) -> Floats:
    """(m, 2c), or (m, c): their product with |f⟩ is A σ_ab, of the pressure 2 A p.

    `distances`: with those of the network, else with the lattice vectors that contacts cross.
    """
    network, c = equation.network, equation.network.contacts
    if distances:
        lever = network.distances[:, None] * network.normals
    else:
        if network.cell is None or network.walls is not None:
            raise ValueError("between walls the mean stress needs distances: data = 'all'")
        lever = network.images @ network.cell
    rows = np.zeros((len(told.data), equation.unknowns))
    for row, (name, _) in zip(rows, told.data, strict=True):
        if name == "p" and distances:
            row[:c] = network.distances
            continue
        pairs = ((0, 0), (1, 1)) if name == "p" else (COMPONENTS[name],)
        for a, b in pairs:
            row[:c] += lever[:, a] * network.normals[:, b]
            if equation.frictional:
                row[c:] -= lever[:, a] * network.tangents[:, b]
    return rows


def stress_sums(told: MeanStress, area: float) -> tuple[Floats, Floats]:
    """(m,) what the rows of `stress_rows` should give, and its standard deviations."""
    times = np.array([2 * area if name == "p" else area for name, _ in told.data])
    value = np.array([one.value for _, one in told.data])
    deviation = np.array([one.deviation for _, one in told.data])
    return times * value, times * deviation


def refuse_free_grains(equation: ForceEquation) -> None:
    """ValueError: the stress is a sum over all contacts, and free grains have some that nobody
    lists."""
    free = np.flatnonzero(equation.network.free)
    if len(free):
        raise ValueError(
            f"{len(free)} grains are free, the first is {free[0]}: contacts that are not listed "
            "bear a part of the mean stress, which therefore is no datum; tell none"
        )
