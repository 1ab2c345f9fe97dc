"""Loads with error bars in the conditions of `optimal`: noise of its own in each balance.

    C y - M_t φ_t + E ζ/κ = F_ext/κ + M_n δ + C y₀ ,     y = ξ ζ

with F_ext as measured (`scaling.estimators.told.loads`). A weak datum is a row for its noise
alone: of norm 1 at most, whatever its error bar.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array, diags_array, hstack

from packing.arguments.arrays import Floats
from scaling.equation.force_equation import ForceEquation
from scaling.noise.noise_model import NoiseModel

WEAK = 1e3
"""Noise of the overlaps, times κ, beyond which an error of a load is as good as infinite."""


def with_load_noise(equation: ForceEquation, noise: NoiseModel, errors: csr_array) -> NoiseModel:
    """The noise with a source more for each column of E; it moves no grain."""
    m = errors.shape[1]
    if not m:
        return noise
    size = np.sqrt(np.asarray(errors.multiply(errors).sum(axis=0)).ravel())
    most = WEAK * equation.stiffness * noise.xi * noise.unit
    errors = csr_array(errors @ diags_array(np.minimum(1.0, most / size)))
    radii, positions = (
        csr_array(hstack([L, csr_array((L.shape[0], m))])) for L in (noise.radii, noise.positions)
    )
    return replace(noise, radii=radii, positions=positions, aside=m, loads=errors)


def load_columns(equation: ForceEquation, noise: NoiseModel) -> csr_array:
    """E/(κ ξ), lengths, (rows of M, k): what the sources of noise do to balance by the loads."""
    rows, k = equation.M.shape[0], noise.count
    if noise.loads is None:
        return csr_array((rows, k))
    κ = 1.0 if equation.law is None else equation.stiffness
    before, m = k - noise.aside, noise.loads.shape[1]
    return csr_array(
        hstack([
            csr_array((rows, before)),
            noise.loads / (κ * noise.xi),
            csr_array((rows, noise.aside - m)),
        ])
    )  # fmt: skip


def load_noise(noise: NoiseModel, y: Floats) -> Floats:
    """ζ (l,) of the y found."""
    if noise.loads is None:
        return np.zeros(0)
    before = noise.count - noise.aside
    return y[before : before + noise.loads.shape[1]] / noise.xi


def row_scale(columns: csr_array, unit: float) -> csr_array:
    """Diagonal: 1 for a strong datum, one over its noise for a weak one."""
    size = np.sqrt(np.asarray(columns.multiply(columns).sum(axis=1)).ravel()) / unit
    return csr_array(diags_array(1 / np.maximum(1.0, size)))
