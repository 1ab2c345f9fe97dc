"""The mean stress told as conditions of `optimal`, in lengths φ = f/κ, each row of norm 1:

    rows φ + e y = told/κ ,     φ_n = δ - B (y - y₀)

so that (e - rows_n B) y + rows_t φ_t = told/κ - rows_n (δ + B y₀). What has an error bar has a
source of noise of its own, y = ξ ζ with ζ a standard normal and e = deviation/(κ ξ). Rows are of
forces across the sides of the cell (`scaling.estimators.told.mean_stress`): of contacts that cross
them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array, hstack

from packing.arguments.arrays import Floats
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.told.mean_stress import (
    MeanStress,
    refuse_free_grains,
    stress_rows,
    stress_sums,
)
from scaling.noise.noise_model import NoiseModel


@dataclass(frozen=True, eq=False)
class StressConditions:
    """Rows for φ (m, 2c), e (m, k), and told/κ (m,)."""

    rows: csr_array
    errors: csr_array
    sums: Floats

    def of_noise(self, B: csr_array) -> csr_array:
        """e - rows_n B, (m, k)."""
        return csr_array(self.errors - self.rows[:, : B.shape[0]] @ B)


def with_stress_noise(noise: NoiseModel, told: MeanStress) -> NoiseModel:
    """The noise with a source more for each component that has an error bar; it moves no grain."""
    u = told.noisy
    if not u:
        return noise
    radii, positions = (
        csr_array(hstack([L, csr_array((L.shape[0], u))])) for L in (noise.radii, noise.positions)
    )
    return replace(noise, radii=radii, positions=positions, aside=noise.aside + u)


def stress_conditions(
    equation: ForceEquation, noise: NoiseModel, told: MeanStress
) -> StressConditions:
    """Those of what was told; none if nothing was.

    ValueError: an open network, or noise that does not know the error bars told.
    """
    n, k = equation.unknowns, noise.count
    if not told.data:
        return StressConditions(csr_array((0, n)), csr_array((0, k)), np.zeros(0))
    area = equation.network.boundary.area
    if area is None:
        raise ValueError("the mean stress of an open network follows from its loads: tell none")
    refuse_free_grains(equation)
    of_loads = 0 if noise.loads is None else noise.loads.shape[1]
    if told.noisy != noise.aside - of_loads:
        raise ValueError(
            "errors are per noise of the geometry: a stress with an error bar of its own has "
            "none; tell it exactly, or ask what `reconstruct` returns for standard_errors()"
        )
    rows = stress_rows(equation, told, distances=False)
    sums, deviations = stress_sums(told, area)
    size = np.linalg.norm(rows, axis=1)
    if not size.all():
        name = told.data[int(np.argmin(size))][0]
        raise ValueError(f"stress {name}: no contact crosses the side of the cell that bears it")
    κ = 1.0 if equation.law is None else equation.stiffness
    errors = deviations / size / (κ * noise.xi)
    # A weak datum is a row for its noise alone: of norm 1 at most, whatever its error bar.
    scale = 1 / np.maximum(1.0, errors / noise.unit)
    noisy = np.flatnonzero(deviations)
    place = (noisy, k - told.noisy + np.arange(told.noisy))
    return StressConditions(
        csr_array(rows * (scale / size)[:, None]),
        csr_array(((scale * errors)[noisy], place), shape=(len(rows), k)),
        scale * sums / size / κ,
    )
