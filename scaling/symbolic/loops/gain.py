"""The gain of a small network: how much noise on its grains is amplified in the forces, exact.

    K² = ‖G⁺(0 ; Q A)‖_F² / 2c,        G⁺ = (GᵀG)⁻¹Gᵀ

(c instead of 2c without friction), with A the map from grain noise to δσ_e.  K² ξ²κ² is the
mean square error of one force component when Eq. 1 is solved by least squares, exact for
size noise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy as sp
from sympy import Expr, Matrix
from sympy.polys.matrices import DomainMatrix

from packing.arguments.numbers import flag
from scaling.symbolic.inputs.closure import loop_vector
from scaling.symbolic.loops.arguments import a_network, a_noise, checked, checked_once
from scaling.symbolic.loops.linear_algebra import solved
from scaling.symbolic.loops.number_field import ExactField
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork


@checked(network=a_network)
def loop_gaps(network: SymbolicNetwork) -> Matrix:
    """Loop sums of the contact diameters, Q|σ⟩.

    Parameters
    ----------
    network : SymbolicNetwork
        Directions and loops of the contacts, and the radii of touching grains.

    Returns
    -------
    Matrix
        (l, 2) x and y component for each of the l loops, on the scale of the radii. They are
        exactly zero when the grains just touch.

    Raises
    ------
    ValueError
        What is no SymbolicNetwork.

    Notes
    -----
    Distances close around every loop, Q|r⟩ = 0, and r = σ between grains that just touch.

    Examples
    --------
    >>> from scaling.symbolic import loop_gaps, triangle
    >>> loop_gaps(triangle()).tolist()
    [[0, 0]]
    """
    exact = ExactField(network)
    vectors = [loop_vector(loop, network.normals, list(network.sigma)) for loop in network.loops]
    return exact.matrix(Matrix(vectors)).to_Matrix()


@checked(network=a_network, noise=a_noise)
def noise_map(network: SymbolicNetwork, noise: str = "diameter") -> Matrix:
    """A: unit noise of the grains to δσ_e in units of ⟨σ⟩, (c, N).

    For positions it is -∂r/∂x, (c, 2N): x of all grains, then y.
    """
    N = network.grains
    A = sp.zeros(network.contacts, 2 * N if noise == "position" else N)
    mean = 2 * sum(network.radii) / N
    share: dict[str, Callable[[int], Expr]] = {
        "diameter": lambda grain: sp.Rational(1, 2),
        "radius": lambda grain: sp.S.One,
        "relative": lambda grain: sp.cancel(network.radii[grain] / mean),
    }
    for e, (i, j) in enumerate(network.pairs):
        if noise == "position":
            for axis in (0, 1):
                A[e, axis * N + i] = network.normals[e][axis]
                A[e, axis * N + j] = -network.normals[e][axis]
        else:
            A[e, i], A[e, j] = (sp.S(share[noise](grain)) for grain in (i, j))
    return A


@checked(network=a_network, frictional=flag, noise=a_noise)
def response(
    network: SymbolicNetwork, frictional: bool = True, noise: str = "diameter"
) -> tuple[DomainMatrix, ExactField]:
    """G⁺(0 ; Q A): forces (in κ) per unit grain noise, over the network's field."""
    exact = ExactField(network)
    G, Q = exact.matrix(network.G(frictional)), exact.matrix(network.Q)
    data = Q * exact.matrix(noise_map(network, noise))
    padded = DomainMatrix.zeros((G.shape[0] - Q.shape[0], data.shape[1]), exact.domain)
    return solved(network, G.transpose() * G, G.transpose() * padded.vstack(data)), exact


@checked_once(network=a_network, frictional=flag, noise=a_noise)
def squared_gain(
    network: SymbolicNetwork, frictional: bool = True, noise: str = "diameter"
) -> Expr:
    """Exact squared gain K²: how much noise on the grains is amplified in the forces.

    Parameters
    ----------
    network : SymbolicNetwork
        Directions and loops of the contacts.
    frictional : bool, default True
        Whether contacts carry transverse forces.
    noise : str, default "diameter"
        What is noisy, by 1 ⟨σ⟩ per grain: "diameter", "radius" or "position" (each
        coordinate); with "relative" each radius is wrong by a factor 1 + η.

    Returns
    -------
    Expr
        K², a rational function of the network's parameters, or an algebraic number.

    Raises
    ------
    ValueError
        What is no SymbolicNetwork, no truth value, or no kind of noise; a G whose columns
        depend on each other.

    Notes
    -----
    K² = ‖G⁺(0 ; Q A)‖_F²/u, with A the map from noise of the grains to δσ_e in ⟨σ⟩ and u the
    number of unknowns. K² ξ²κ² is the mean square error of one force component for noise of
    standard deviation ξ⟨σ⟩.

    Examples
    --------
    >>> from scaling.symbolic import ring, squared_gain
    >>> squared_gain(ring(3), frictional=False)
    1/24
    >>> squared_gain(ring(3), frictional=False, noise="radius")  # twice the amplitude
    1/6
    """
    X, exact = response(network, frictional, noise)
    total = _sum_of_squares([x for row in X.to_list() for x in row], exact.domain)
    return sp.factor(exact.expression(total / exact.domain(X.shape[0])))


def _sum_of_squares(elements: list[Any], domain: Any) -> Any:
    """Σ x²; fractions of one denominator, as a common determinant makes them, are added first."""
    if not domain.is_FractionField:
        return sum((x * x for x in elements), domain.zero)
    numerators: dict[Any, Any] = {}
    for x in elements:
        numerators[x.denom] = numerators.get(x.denom, 0) + x.numer**2
    fractions = (domain.field.new(top, bottom**2) for bottom, top in numerators.items())
    return sum(fractions, domain.zero)
