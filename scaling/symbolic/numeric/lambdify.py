"""The one way from symbols to numbers: lambdified matrices, contact blocks and laws.

    symbolic network  →  ContactNetwork, M, Q, G as NumPy arrays
    contact block, contact expansion, contact law →  functions for networks of any size

Everything else in `scaling.symbolic` is exact; everything else in `scaling` never sees sympy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from packing.arguments.arrays import real_array
from packing.arguments.numbers import finite_number, flag, number_between
from scaling import ContactNetwork
from scaling.symbolic.argument import perturbation
from scaling.symbolic.inputs.equilibrium import balance_matrix
from scaling.symbolic.loops.arguments import a_network, a_noise, assignments, checked
from scaling.symbolic.loops.gain import noise_map
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork

Array = NDArray[np.float64]


@checked(network=a_network, values=assignments)
def values_of(
    network: SymbolicNetwork, values: Mapping[sp.Symbol, Any] | None = None
) -> dict[sp.Symbol, Any]:
    """Numbers for all parameters: the given ones, else the sample, and the fixed ones."""
    chosen = {**network.sample, **(values or {}), **network.fixed}
    foreign = [str(name) for name in values or {} if name not in network.sample]
    if foreign:
        raise ValueError(f"values: {network.name} has no free parameter {', '.join(foreign)}")
    return {name: finite_number(str(name), value) for name, value in chosen.items()}


@checked(network=a_network, values=assignments)
def evaluated(
    network: SymbolicNetwork, expr: Any, values: Mapping[sp.Symbol, Any] | None = None
) -> Any:
    """Return an expression or matrix in the network's parameters as float or NumPy array."""
    numbers = values_of(network, values)
    result = sp.lambdify(list(numbers), expr, "numpy")(*numbers.values())
    return np.asarray(result, dtype=float) if np.ndim(result) else float(result)


@checked(network=a_network, frictional=flag, values=assignments)
def matrices(
    network: SymbolicNetwork,
    frictional: bool = True,
    values: Mapping[sp.Symbol, Any] | None = None,
) -> tuple[Array, Array, Array]:
    """M, Q and G of a symbolic network as dense arrays."""
    exact = (network.M(frictional), network.Q, network.G(frictional))
    M, Q, G = (evaluated(network, matrix, values) for matrix in exact)
    return M, Q, G


@checked(network=a_network, frictional=flag, noise=a_noise, values=assignments)
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


@checked(network=a_network, values=assignments)
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
    return _function([nx, ny], balance_matrix(2, [(0, 1)], [(nx, ny)]).tolist())


@cache
def expansion() -> Callable[..., Any]:
    """(r, u_n, u_t) ↦ ((δr, n·δn, t·δn) at first order, the same at second order)."""
    p = perturbation
    return _function([p.distance, p.along, p.across], p.contact_expansion())


def law(exponent: float) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """y ↦ f̂ = sign(y)|y|^α and its slope α|y|^(α-1), y = δ/Δ; inverse of `signed_overlap`.

    ValueError: α not between 0.001 and 100, and of the functions a y at which they are infinite.
    """
    number = number_between("exponent", exponent, 1e-3, 100)
    return _law(exponent if isinstance(exponent, sp.Expr) else sp.nsimplify(number))


@cache
def _law(alpha: sp.Expr) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    y = sp.Symbol("y", real=True)
    size = sp.Abs(y)
    return _function([y], sp.sign(y) * size**alpha), _function([y], alpha * size ** (alpha - 1))


def _function(symbols: Sequence[sp.Symbol], expressions: Any) -> Callable[..., Any]:
    """Expressions, nested in lists or tuples, as functions of arrays.

    Every result has the shape of the arguments together, those of constants too. ValueError: an
    argument that is no array of numbers, or at which a result is not finite.
    """
    lambdified = sp.lambdify(symbols, expressions, "numpy")
    names = [str(symbol) for symbol in symbols]

    def evaluate(*values: Any) -> Any:
        if len(values) != len(names):
            raise ValueError(f"{len(values)} arguments, expected {', '.join(names)}")
        arrays = [real_array(name, value) for name, value in zip(names, values, strict=True)]
        shapes = [array.shape for array in arrays]
        try:
            shape = np.broadcast_shapes(*shapes)
        except ValueError:
            raise ValueError(f"{', '.join(names)} have the shapes {shapes}") from None

        def filled(result: Any) -> Any:
            if isinstance(result, list | tuple):
                return type(result)(filled(each) for each in result)
            whole = np.array(np.broadcast_to(np.asarray(result, dtype=float), shape))
            wrong = np.argwhere(~np.isfinite(whole))
            if len(wrong):
                at = [np.broadcast_to(array, shape)[tuple(wrong[0])] for array in arrays]
                raise ValueError(f"{', '.join(names)} = {at}: the result is not finite")
            return whole

        with np.errstate(all="ignore"):
            return filled(lambdified(*arrays))

    return evaluate
