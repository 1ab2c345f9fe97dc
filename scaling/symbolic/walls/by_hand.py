"""Small networks between walls, solved by hand.

    corner      one grain on two walls: rank 3 of 4 with friction, 2 of 2 without
    slit        two grains from floor to top: rank 5 of 6, until a distance or a load is told
    bridge      three grains side by side on a floor: what balance leaves open, the floor closes
    column      grains on top of each other: forces are the weights above
    heap        two grains on a floor and one on top, which touch each other below or do not

Parameters are tangents of half angles, u, and positive.
"""

from __future__ import annotations

import sympy as sp

from packing.arguments.numbers import choice, flag
from scaling.symbolic.inputs.equilibrium import Direction
from scaling.symbolic.loops.arguments import LARGEST, checked_once, whole
from scaling.symbolic.loops.named_networks import u
from scaling.symbolic.loops.symbolic_network import direction
from scaling.symbolic.walls.walled_network import WalledNetwork

ONE, ZERO, HALF = sp.S.One, sp.S.Zero, sp.Rational(1, 2)
FLOOR: Direction = (ZERO, -ONE)
TOP: Direction = (ZERO, ONE)


def corner() -> WalledNetwork:
    """One grain between a floor and a wall beside it that leans at any angle.

    Returns
    -------
    WalledNetwork
        Two feet, on walls 0 (leaning) and 1 (the floor).

    Notes
    -----
    The parameter is u = tan of half the angle by which the wall leans from upright; n of the wall
    is (-cos, -sin) of it. No row joins two walls: forces are those of balance alone.

    Examples
    --------
    >>> from scaling.symbolic import corner
    >>> corner().rank(), corner().rank(frictional=False)
    (3, 2)
    """
    cos, sin = direction(u)
    walls = ((-cos, -sin), FLOOR)
    return WalledNetwork(
        "corner", ((ZERO, ZERO),), (HALF,), (), ((0, 0), (0, 1)), walls,
        sample={u: sp.Rational(1, 5)},
    )  # fmt: skip


def slit(told: str = "nothing") -> WalledNetwork:
    """Two equal grains in a column from a floor to the wall opposite.

    Parameters
    ----------
    told : str, default "nothing"
        "nothing", "distance" (of the walls: a row from wall to wall) or "load" (of the top wall).

    Returns
    -------
    WalledNetwork
        A pair and two feet, on walls 0 (below) and 1 (above).

    Raises
    ------
    ValueError
        `told` is none of the three.

    Examples
    --------
    >>> from scaling.symbolic import slit
    >>> [slit(told).rank() for told in ("nothing", "distance", "load")]
    [5, 6, 6]
    """
    choice("told", told, ("nothing", "distance", "load"))
    across = (((1, -1), (0, 1), (2, 1)),) if told == "distance" else ()
    return WalledNetwork(
        "slit", ((ZERO, HALF), (ZERO, 3 * HALF)), (HALF, HALF), ((0, 1),), ((0, 0), (1, 1)),
        (FLOOR, TOP), ways=across, weighed=(1,) if told == "load" else (),
    )  # fmt: skip


def bridge(one_floor: bool = True) -> WalledNetwork:
    """Three grains side by side, the middle one larger, each with a foot; no face.

    Parameters
    ----------
    one_floor : bool, default True
        Whether the feet stand on one wall, or each on one of which nobody knows how it lies.

    Returns
    -------
    WalledNetwork
        Two pairs and three feet.

    Raises
    ------
    ValueError
        `one_floor` is no truth value.

    Notes
    -----
    The parameter is u = tan of half the slope of the contacts: the middle grain is the larger.

    Examples
    --------
    >>> from scaling.symbolic import bridge
    >>> bridge().rank(matrix="M"), bridge().rank(), bridge(one_floor=False).rank()
    (9, 10, 9)
    """
    flag("one_floor", one_floor)
    cos, sin = direction(u)
    middle = HALF * (1 + sin) / (1 - sin)
    along = (HALF + middle) * cos
    centres = ((ZERO, HALF), (along, middle), (2 * along, HALF))
    feet = tuple((i, 0 if one_floor else i) for i in range(3))
    ways = (((2, -1), (0, 1), (3, 1)), ((3, -1), (1, 1), (4, 1))) if one_floor else ()
    return WalledNetwork(
        "bridge", centres, (HALF, middle, HALF), ((0, 1), (1, 2)), feet,
        (FLOOR,) * (1 if one_floor else 3), ways=ways, sample={u: sp.Rational(1, 20)},
    )  # fmt: skip


@checked_once(grains=whole(1, LARGEST))
def column(grains: int = 3) -> WalledNetwork:
    """Equal grains on top of each other on a floor.

    Parameters
    ----------
    grains : int, default 3
        1 to 1000.

    Returns
    -------
    WalledNetwork
        Its pairs from below, then the foot.

    Raises
    ------
    ValueError
        `grains` is no such whole number.

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import column
    >>> weights = sp.Matrix([0, 0, 0, -1, -1, -1, 0, 0, 0])
    >>> column(3).forces(weights, sp.zeros(0, 1)).T.tolist()
    [[2, 1, 3, 0, 0, 0]]
    """
    centres = tuple((ZERO, HALF + k) for k in range(grains))
    pairs = tuple((k, k + 1) for k in range(grains - 1))
    return WalledNetwork("column", centres, (HALF,) * grains, pairs, ((0, 0),), (FLOOR,))


def heap(base: bool = False) -> WalledNetwork:
    """Two equal grains on a floor and one on top of them.

    Parameters
    ----------
    base : bool, default False
        Whether the two below touch each other.

    Returns
    -------
    WalledNetwork
        Pairs 0-2 and 1-2, then 0-1 if they touch, then two feet.

    Raises
    ------
    ValueError
        `base` is no truth value.

    Notes
    -----
    The parameter is u = tan(ψ/2), 2ψ the angle at the grain on top. Open, it stands by friction
    alone: f_t/f_n = u at the upper contacts whatever the weights.

    Examples
    --------
    >>> from scaling.symbolic import heap
    >>> heap().rank(), heap(base=True).rank()
    (8, 10)
    """
    flag("base", base)
    cos, sin = direction(u)
    below = sin if base else sin / 2
    centres = ((-sin, below), (sin, below), (ZERO, below + cos))
    pairs = ((0, 2), (1, 2), *(((0, 1),) if base else ()))
    left, right = len(pairs), len(pairs) + 1
    across = ((2, 1),) if base else ((0, 1), (1, -1))
    return WalledNetwork(
        "heap", centres, (below, below, 1 - below), pairs, ((0, 0), (1, 0)), (FLOOR,),
        loops=(((2, 1), (1, 1), (0, -1)),) if base else (),
        ways=(((left, -1), *across, (right, 1)),), sample={u: sp.Rational(1, 4)},
    )  # fmt: skip
