"""What the program of `bounded` is told of the mean stress, as rows, noise and a prior of t.

    rows φ (+ rows φ' t) + e ζ = told ,     ζ standard normals,   t = (p/p' - 1) ± e_p/p'

with φ = f/f̄, and p' the pressure of f̄. Where the stress does not fix f̄, φ has the mean force 1,
a row of its own, and t says by how much f̄ is to grow: see `scaling.estimators.bounded.program`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array, hstack

from packing.arguments.arrays import Floats
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.told.datum import Datum
from scaling.estimators.told.mean_stress import stress_rows, stress_sums


@dataclass(frozen=True, eq=False)
class StressData:
    """Rows for φ and what they give; rows, P and q of their noise and of t, which comes last."""

    rows: csr_array
    sums: Floats
    noise: csr_array
    P: Floats
    q: Floats
    growing: Floats | None = None
    """φ', where f̄ is not fixed."""

    def grow(self, rows: csr_array) -> csr_array:
        """What `rows` for f/f̄ have for the noise and for t."""
        return _columns(rows, len(self.P) - (self.growing is not None), self.growing)


def stress_data(p: Posterior, last: Floats, shift: Floats | None) -> StressData:
    """At f/f̄ = `last`; `shift` moves what has an error bar by so many of them, the pressure first.

    None on open networks, where balance implies the mean force, and with free grains, where other
    contacts share the stress."""
    network, n = p.equation.network, p.equation.unknowns
    area = network.boundary.area
    if area is None or network.free.any():
        none = csr_array((0, n))
        return StressData(none, np.zeros(0), csr_array((0, 0)), np.zeros(0), np.zeros(0))
    pressure, told = p.stress.pressure, p.stress
    here = Datum(p.virial / (2 * area))
    if p.floats:
        told = replace(told, pressure=here)
    rows = stress_rows(p.equation, told, p.noise is not None and p.data == "all")
    sums, errors = stress_sums(told, area)
    # A row has up to 2c entries: made to weigh like one contact.
    unit = np.linalg.norm(rows, axis=1)
    rows, sums, errors = (
        rows / unit[:, None],
        sums / p.mean_force / unit,
        errors / p.mean_force / unit,
    )
    noisy = np.flatnonzero(errors)
    aside = int(p.floats and pressure is not None)
    if shift is not None:
        sums[noisy] += errors[noisy] * shift[aside:]
    # Unit prior of a weak error, unit effect of a strong one.
    g = np.maximum(1.0, errors[noisy])
    ζ = np.zeros((len(rows), len(noisy)))
    ζ[noisy, np.arange(len(noisy))] = -errors[noisy] / g
    P, q = g**-2.0, np.zeros(len(noisy))
    if not p.floats:
        return StressData(csr_array(rows), sums, csr_array(ζ), P, q)
    grown = rows @ last
    grown[0] = 0.0  # the mean of φ is 1, whatever t
    precision, target = 0.0, 0.0
    if pressure is not None:
        precision = (here.value / pressure.deviation) ** 2
        target = pressure.value / here.value - 1
        if shift is not None:
            target += shift[0] / np.sqrt(precision)
    noise = csr_array(np.column_stack([ζ, grown]))
    return StressData(
        csr_array(rows),
        sums,
        noise,
        np.append(P, precision),
        np.append(q, -precision * target),
        last,
    )


def _columns(rows: csr_array, others: int, growing: Floats | None) -> csr_array:
    blank = csr_array((rows.shape[0], others))
    if growing is None:
        return blank
    return csr_array(hstack([blank, csr_array((rows @ growing)[:, None])]))
