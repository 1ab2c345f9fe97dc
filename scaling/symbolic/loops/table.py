"""The table of small networks: counts, ranks, null spaces and squared gains, all exact."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from packing.arguments.numbers import flag
from scaling.symbolic.loops.arguments import a_network, checked, whole
from scaling.symbolic.loops.gain import squared_gain
from scaling.symbolic.loops.linear_algebra import rank
from scaling.symbolic.loops.named_networks import bowtie, rhombus, ring, square, triangle, wheel
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork

MOST = 24
"""Grains of the largest ring of the table: exact gains of larger ones take hours."""


@dataclass(frozen=True)
class Row:
    """One network, with or without friction.

    Attributes
    ----------
    name : str
        Of the network.
    frictional : bool
        Whether contacts carry transverse forces.
    grains, contacts : int
        N and c.
    unknowns, equations : int
        Columns and rows of G.
    self_stress : int
        Dimension of the null space of M: forces that need no load.
    rank : int
        Of G; equal to `unknowns` for a unique least-squares solution.
    squared_gain : Expr
        K² for noise on the diameters, exact.
    value : float
        K² at the network's sample geometry.
    """

    name: str
    frictional: bool
    grains: int
    contacts: int
    unknowns: int
    equations: int
    self_stress: int
    rank: int
    squared_gain: Expr
    value: float


@checked(network=a_network, frictional=flag)
def row(network: SymbolicNetwork, frictional: bool) -> Row:
    """Return the table row of one network."""
    G = network.G(frictional)
    gain = squared_gain(network, frictional)
    return Row(
        name=network.name,
        frictional=frictional,
        grains=network.grains,
        contacts=network.contacts,
        unknowns=G.cols,
        equations=G.rows,
        self_stress=G.cols - rank(network, frictional, matrix="M"),
        rank=rank(network, frictional),
        squared_gain=gain,
        value=float(gain.subs(network.sample)),
    )


def small_networks(largest: int = 8) -> Iterator[SymbolicNetwork]:
    """Triangle, square, rhombus, bowtie, rings up to `largest`, wheels of 3 to 6 rim grains."""
    yield from (triangle(), square(), rhombus(), bowtie())
    yield from (ring(n) for n in range(3, largest + 1))
    yield from (wheel(n) for n in range(3, min(largest, 6) + 1))


@checked(largest=whole(3, MOST))
def table(largest: int = 8) -> tuple[Row, ...]:
    """Ranks, null spaces and squared gains of all small networks. It takes seconds.

    Parameters
    ----------
    largest : int, default 8
        3 to 24 grains of the largest ring.

    Returns
    -------
    tuple of Row
        Two rows for each network of `small_networks`, without and with friction.

    Raises
    ------
    ValueError
        `largest` is no such whole number.

    Examples
    --------
    One row of it; the whole takes seconds.

    >>> from scaling.symbolic import bowtie
    >>> from scaling.symbolic.loops.table import row
    >>> one = row(bowtie(), frictional=False)
    >>> one.rank, one.self_stress, f"{one.value:.5f}"
    (6, 0, '0.05853')
    """
    return tuple(
        row(network, frictional)
        for network in small_networks(largest)
        for frictional in (False, True)
    )


def markdown(rows: tuple[Row, ...]) -> str:
    """Return the table as Markdown; gains longer than a line appear by their value only."""
    lines = [
        "| network | friction | N | c | equations × unknowns | rank | self-stress | K² | value |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for r in rows:
        formula = sp.latex(r.squared_gain)
        shown = f"${formula}$" if len(formula) < 60 else "(see the closed forms)"
        lines.append(
            f"| {r.name} | {'yes' if r.frictional else 'no'} | {r.grains} | {r.contacts} "
            f"| {r.equations} × {r.unknowns} | {r.rank} | {r.self_stress} | {shown} "
            f"| {r.value:.5f} |"
        )
    return "\n".join(lines)
