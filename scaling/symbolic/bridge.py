"""The one way from symbols to numbers: lambdified matrices, contact blocks and laws.

    symbolic network  →  ContactNetwork, M, Q, G as NumPy arrays
    contact block, contact expansion, contact law →  functions for networks of any size

Everything else in `scaling.symbolic` is exact; everything else in `scaling` never sees sympy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from scaling import ContactNetwork
from scaling.symbolic import perturbation
from scaling.symbolic.equilibrium import balance_matrix
from scaling.symbolic.gain import noise_map
from scaling.symbolic.network import SymbolicNetwork

Array = NDArray[np.float64]


def values_of(
    network: SymbolicNetwork, values: Mapping[sp.Symbol, Any] | None = None
) -> dict[sp.Symbol, Any]:
    """Numbers for all parameters: the given ones, else the sample, and the fixed ones."""
    chosen = {**network.sample, **(values or {}), **network.fixed}
    foreign = [str(name) for name in values or {} if name not in network.sample]
    if foreign:
        raise ValueError(f"{network.name} has no free parameter {', '.join(foreign)}")
    return {name: float(value) for name, value in chosen.items()}


def evaluated(
    network: SymbolicNetwork, expr: Any, values: Mapping[sp.Symbol, Any] | None = None
) -> Any:
    """Return an expression or matrix in the network's parameters as float or NumPy array."""
    numbers = values_of(network, values)
    result = sp.lambdify(list(numbers), expr, "numpy")(*numbers.values())
    return np.asarray(result, dtype=float) if np.ndim(result) else float(result)


def matrices(
    network: SymbolicNetwork,
    frictional: bool = True,
    values: Mapping[sp.Symbol, Any] | None = None,
) -> tuple[Array, Array, Array]:
    """M, Q and G of a symbolic network as dense arrays."""
    exact = (network.M(frictional), network.Q, network.G(frictional))
    M, Q, G = (evaluated(network, matrix, values) for matrix in exact)
    return M, Q, G


def gain(
    network: SymbolicNetwork,
    frictional: bool = True,
    noise: str = "diameter",
    values: Mapping[sp.Symbol, Any] | None = None,
) -> float:
    """K from the lambdified matrices by floating-point pseudo-inverse; error ~ eps cond(G)²."""
    _, Q, G = matrices(network, frictional, values)
    A = evaluated(network, noise_map(network, noise), values)
    response = np.linalg.pinv(G)[:, G.shape[0] - Q.shape[0] :] @ Q @ A
    return float(np.linalg.norm(response) / np.sqrt(G.shape[1]))


def contact_network(
    network: SymbolicNetwork, values: Mapping[sp.Symbol, Any] | None = None
) -> ContactNetwork:
    """Return the touching grains as a numeric network: centres found by walking contacts."""
    numbers = values_of(network, values)
    radii = evaluated(network, sp.Matrix(network.radii), values).ravel()
    normals = evaluated(network, sp.Matrix(network.normals), values)
    positions = np.full((network.grains, 2), np.nan)
    positions[0] = 0
    while np.isnan(positions).any():
        for (i, j), n in zip(network.pairs, normals, strict=True):
            step = (radii[i] + radii[j]) * n
            if np.isnan(positions[j]).any():
                positions[j] = positions[i] + step
            if np.isnan(positions[i]).any():
                positions[i] = positions[j] - step
    if not (radii > 0).all():
        raise ValueError(f"{network.name} at {numbers}: radii {radii} are not all positive")
    return ContactNetwork(positions, radii, np.array(network.pairs))


@cache
def contact_block() -> Callable[..., Any]:
    """(n_x, n_y) ↦ the 6 × 2 block of M for one contact: rows x_i x_j y_i y_j τ_i τ_j."""
    nx, ny = sp.symbols("n_x n_y", real=True)
    return sp.lambdify([nx, ny], balance_matrix(2, [(0, 1)], [(nx, ny)]).tolist(), "numpy")


@cache
def expansion() -> Callable[..., Any]:
    """(r, u_n, u_t) ↦ ((δr, n·δn, t·δn) at first order, the same at second order)."""
    p = perturbation
    return sp.lambdify([p.distance, p.along, p.across], p.contact_expansion(), "numpy")


@cache
def law(exponent: float) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """y ↦ f̂ = sign(y)|y|^α and its slope α|y|^(α-1), y = δ/Δ; inverse of `signed_overlap`."""
    y = sp.Symbol("y", real=True)
    alpha = sp.nsimplify(exponent)
    size = sp.Abs(y)
    return sp.lambdify(y, sp.sign(y) * size**alpha), sp.lambdify(y, alpha * size ** (alpha - 1))
