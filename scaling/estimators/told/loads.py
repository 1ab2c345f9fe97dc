"""Loads on grains and of walls as data: what they are measured to be, and how they err.

    M|f⟩ = b + E ζ ,     b = -|F_ext⟩ as measured ,   E Eᵀ their covariance ,   ζ standard normals

As the error bar goes to 0 the load is a condition again; as it grows, the row of M says nothing,
as that of a grain whose balance is not required (`ContactNetwork.freed`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from packing.arguments.arrays import real_array
from packing.arguments.numbers import number_from_zero
from scaling.equation.force_equation import ForceEquation
from scaling.geometry.bodies import held_components
from scaling.noise.covariance import factor

Loads = float | ArrayLike
"""A standard deviation, (N, 3) of them, or a covariance; see `load_errors`."""
SIGMAS = 6.0
"""Deviations that no Gaussian error exceeds."""
_DIGITS = float(np.sqrt(np.finfo(float).eps))


def load_errors(equation: ForceEquation, told: Any) -> csr_array:
    """E, (rows of M, l); forces, torques over radii.

    `told`: a number, the standard deviation of each force on grains that bear a load (of torques
    that times R) and of each wall's that was weighed; or (N, 3) of F_x, F_y and T; or 3N
    variances, or a covariance, of (F_x ; F_y ; T), all F_x first, and then of the w walls that
    were weighed, if they are told: 3N or 3N + w. Zeros are exact, None is all exact. ValueError:
    none of these, or net forces that even so are too far from 0.
    """
    if told is None:
        return csr_array((equation.M.shape[0], 0))
    E = csr_array(_on_rows(equation) @ _deviations(equation, told))
    E.eliminate_zeros()
    E = csr_array(E[:, np.flatnonzero(abs(E).sum(axis=0))])
    _refuse_beyond_errors(equation, E)
    return E


def _deviations(equation: ForceEquation, told: Any) -> csr_array:
    """L (3N + w, l) of (F_x ; F_y ; T ; walls)."""
    network, w = equation.network, len(equation.matrices.balancing.walls)
    N = network.grains
    if np.ndim(told) == 0:
        s = number_from_zero("loads", told)
        bears = np.where(network.external.any(axis=1), s, 0.0)
        each = np.concatenate([bears, bears, bears * network.radii, np.full(w, s)])
        return factor("loads", each**2, (3 * N + w,))
    if np.shape(told) == (N, 3):
        sd = real_array("loads", told, (N, 3), "grain")
        if (sd < 0).any():
            i = int(np.argmax((sd < 0).any(axis=1)))
            raise ValueError(f"loads: grain {i} has the deviation {sd[i].min():.3g}, negative")
        return factor("loads", np.append(sd.T.ravel(), np.zeros(w)) ** 2, (3 * N + w,))
    L = factor("loads", told, (3 * N, 3 * N + w) if w else (3 * N,))
    L.resize(3 * N + w, L.shape[1])
    return L


def _on_rows(equation: ForceEquation) -> csr_array:
    """(rows of M, 3N + w): M f = -F for grains, +F for walls, F that measured less its error."""
    network, balancing = equation.network, equation.matrices.balancing
    N, active, w = network.grains, balancing.active, len(balancing.walls)
    kinds = 3 if equation.frictional else 2
    column = np.append(np.arange(kinds)[:, None] * N + active, 3 * N + np.arange(w))
    arms = [np.ones(2 * len(active)), np.tile(1 / network.radii[active], kinds - 2), -np.ones(w)]
    place = (np.arange(len(column)), column)
    return csr_array((np.concatenate(arms), place), shape=(len(column), 3 * N + w))


def _refuse_beyond_errors(equation: ForceEquation, E: csr_array) -> None:
    """ValueError: a net force, on what nothing holds, that its error does not explain."""
    component, active = equation.network.forest.component, equation.network.active
    b, n = equation.balance_rhs(), len(active)
    for label in np.setdiff1d(component[active], held_components(equation.network)):
        mine = np.flatnonzero(component[active] == label)
        for axis, name in enumerate("xy"):
            rows = mine + axis * n
            net, total = float(b[rows].sum()), float(abs(b[rows]).sum())
            error = float(np.linalg.norm(E[rows].sum(axis=0)))
            if abs(net) > SIGMAS * error + _DIGITS * total:
                raise ValueError(
                    f"the loads cannot be balanced: their net force along {name} on the component "
                    f"of grain {active[mine[0]]} is {-net:.4g}, and its error as told {error:.3g}"
                )
