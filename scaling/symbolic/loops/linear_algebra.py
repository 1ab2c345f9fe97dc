"""Exact rank, null space and pseudo-inverse of the matrices of a small network.

    G⁺ = (GᵀG)⁻¹Gᵀ

Sines and cosines are rational in tan(φ/2), so all of it is linear algebra over one field: QQ(u, v)
for free angles, QQ(tan π/n) for regular polygons.
"""

from __future__ import annotations

import sympy as sp
from sympy import Matrix
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError

from packing.arguments.numbers import flag
from scaling.symbolic.loops.arguments import a_network, checked, one_of
from scaling.symbolic.loops.number_field import ExactField
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork


@checked(network=a_network, frictional=flag, matrix=one_of("G", "M", "Q"))
def rank(network: SymbolicNetwork, frictional: bool = True, matrix: str = "G") -> int:
    """Return the exact rank of a matrix of the network, for generic angles.

    Parameters
    ----------
    network : SymbolicNetwork
        Directions and loops of the contacts.
    frictional : bool, default True
        Whether contacts carry transverse forces.
    matrix : str, default "G"
        "G", "M" (its balance rows) or "Q" (its closure rows).

    Returns
    -------
    int
        The rank over the field of the network's parameters.

    Raises
    ------
    ValueError
        What is no SymbolicNetwork, no truth value, or none of the three matrices.

    Notes
    -----
    The forces are unique in least squares when the rank of G is the number of its columns.

    Examples
    --------
    >>> from scaling.symbolic import rank, rhombus
    >>> rank(rhombus()), rhombus().G().shape
    (10, (16, 10))
    >>> rank(rhombus(), matrix="M")  # balance leaves one combination of forces open
    9
    """
    return ExactField(network).matrix(_named(network, matrix, frictional)).rank()


@checked(network=a_network, frictional=flag, matrix=one_of("G", "M", "Q"))
def null_space(network: SymbolicNetwork, frictional: bool = True, matrix: str = "M") -> Matrix:
    """Exact null space of a matrix of the network.

    Parameters
    ----------
    network : SymbolicNetwork
        Directions and loops of the contacts.
    frictional : bool, default True
        Whether contacts carry transverse forces.
    matrix : str, default "M"
        "G", "M" or "Q".

    Returns
    -------
    Matrix
        One column per vector: (2c, k), or (c, k) without friction and for Q. Those of M are the
        force networks that need no load.

    Raises
    ------
    ValueError
        What is no SymbolicNetwork, no truth value, or none of the three matrices.

    Examples
    --------
    >>> from scaling.symbolic import null_space, rhombus, triangle
    >>> null_space(triangle()).shape
    (6, 0)
    >>> selfstress = null_space(rhombus())
    >>> selfstress.shape
    (10, 1)
    """
    exact = ExactField(network)
    rows = exact.matrix(_named(network, matrix, frictional)).nullspace()
    return rows.to_Matrix().T if rows.shape[0] else sp.zeros(rows.shape[1], 0)


@checked(network=a_network, frictional=flag)
def pseudo_inverse(network: SymbolicNetwork, frictional: bool = True) -> Matrix:
    """Exact pseudo-inverse of G: from the data of Eq. 1 to the forces.

    Parameters
    ----------
    network : SymbolicNetwork
        Directions and loops of the contacts.
    frictional : bool, default True
        Whether contacts carry transverse forces.

    Returns
    -------
    Matrix
        G⁺ = (GᵀG)⁻¹Gᵀ, (unknowns, equations).

    Raises
    ------
    ValueError
        What is no SymbolicNetwork or no truth value; a G whose columns depend on each other.

    Examples
    --------
    >>> from scaling.symbolic import pseudo_inverse, ring
    >>> G = ring(3).G(frictional=False)
    >>> (pseudo_inverse(ring(3), frictional=False) * G.subs(ring(3).fixed)).tolist()
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    """
    G = ExactField(network).matrix(network.G(frictional))
    return solved(network, G.transpose() * G, G.transpose()).to_Matrix()


def solved(network: SymbolicNetwork, H: DomainMatrix, right: DomainMatrix) -> DomainMatrix:
    """H⁻¹ times the right-hand sides, H = GᵀG; ValueError for a G without full column rank."""
    try:
        return H.to_dense().lu_solve(right.to_dense())
    except DMNonInvertibleMatrixError:
        found = H.to_dense().rank()
        raise ValueError(
            f"{network.name}: G has rank {found} of {H.shape[0]}, null space of dimension "
            f"{H.shape[0] - found}: some forces change neither a balance nor a loop"
        ) from None


def _named(network: SymbolicNetwork, matrix: str, frictional: bool) -> Matrix:
    if matrix == "Q":
        return network.Q
    return network.G(frictional) if matrix == "G" else network.M(frictional)
