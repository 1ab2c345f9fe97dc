"""A covariance as independent sources: Σ = L Lᵀ."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array, issparse

from packing.arguments.arrays import Floats, real_array

_ASYMMETRY = 1e-10
"""Relative to √(C_aa C_bb): sums of a million products err by less, data by far more."""


def factor(name: str, covariance: Any, sizes: tuple[int, ...]) -> csr_array:
    """L with L Lᵀ = covariance, and no column for exact data; it goes by `name` in messages.

    ValueError: not n variances or an n × n matrix, n one of `sizes`, or no covariance.
    """
    dense = covariance.toarray() if issparse(covariance) else covariance
    matrix = real_array(name, dense)
    n = matrix.shape[0] if matrix.ndim else 0
    if n not in sizes or matrix.shape not in ((n,), (n, n)):
        raise ValueError(
            f"{name} has shape {matrix.shape}, expected {' or '.join(map(str, sizes))} "
            "variances, or a square matrix of that size"
        )
    if matrix.ndim == 2:
        matrix = _symmetric(name, matrix)
    diagonal = matrix if matrix.ndim == 1 else matrix.diagonal()
    if (diagonal < 0).any():
        k = int(np.argmax(diagonal < 0))
        raise ValueError(f"{name}: variance {k} is {diagonal[k]:.3g}, negative")
    if matrix.ndim == 1 or not (matrix - np.diag(diagonal)).any():
        noisy = np.flatnonzero(diagonal)
        values = np.sqrt(diagonal[noisy])
        return csr_array((values, (noisy, np.arange(len(noisy)))), shape=(n, len(noisy)))
    λ, U = np.linalg.eigh(matrix)
    if λ[0] < -1e-12 * λ[-1]:
        raise ValueError(f"{name} has the negative eigenvalue {λ[0]:.3g}")
    kept = λ > 1e-14 * λ[-1]
    return csr_array(U[:, kept] * np.sqrt(λ[kept]))


def _symmetric(name: str, matrix: Floats) -> Floats:
    """The mean of `matrix` and its transpose, if they differ by rounding only.

    Rounding of entry (a, b) is a multiple of ε √(C_aa C_bb), the scale of what it was computed
    from, whatever the entry itself is: 0 may come out as ±1e-17 of it.
    """
    scale = np.sqrt(abs(matrix.diagonal()))
    allowed = _ASYMMETRY * np.maximum(np.outer(scale, scale), abs(matrix))
    off = abs(matrix - matrix.T) - allowed
    if (off > 0).any():
        a, b = np.unravel_index(int(np.argmax(off)), off.shape)
        raise ValueError(
            f"{name} is not symmetric: entry ({a}, {b}) is {matrix[a, b]:.6g} and entry "
            f"({b}, {a}) {matrix[b, a]:.6g}"
        )
    return (matrix + matrix.T) / 2
