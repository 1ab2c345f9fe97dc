"""Pictures of networks: grains, contacts, their directions.  matplotlib only when drawing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from packing.contacts import contact_list
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork
from scaling.symbolic.numeric.lambdify import contact_network


def draw(
    network: SymbolicNetwork,
    values: Mapping[sp.Symbol, Any] | None = None,
    *,
    forces: ArrayLike | None = None,
    ax: Any = None,
) -> Any:
    """Draw touching grains, and contacts from centre to centre; return the axes.

    `forces` (c,) or (2c,): red lines are compressed, blue ones stretched contacts, of width |f_n|;
    short bars across a contact are f_t.
    """
    import matplotlib.pyplot as plt
    from matplotlib.patches import Circle

    numeric = contact_network(network, values)
    if ax is None:
        _, ax = plt.subplots(figsize=(3, 3))
    x = numeric.positions
    assert x is not None
    for grain, (centre, radius) in enumerate(zip(x, numeric.radii, strict=True)):
        ax.add_patch(Circle(tuple(centre), radius, fc="0.92", ec="0.5"))
        ax.annotate(str(grain), centre, ha="center", va="center", fontsize=8, color="0.3")
    c = numeric.contacts
    strength = np.zeros(2 * c)
    if forces is not None:
        given, _ = contact_list.forces(forces, c)
        strength[: given.size] = given / (np.abs(given).max() or 1.0)
    for e, (i, j) in enumerate(numeric.pairs):
        f_n, f_t = strength[e], strength[c + e]
        colour = "0.6" if forces is None else ("C3" if f_n >= 0 else "C0")
        width = 1 if forces is None else 4 * abs(f_n)
        ax.plot(*x[[i, j]].T, color=colour, lw=width, zorder=2, solid_capstyle="round")
        if forces is not None and f_t:
            touch = x[i] + numeric.radii[i] * numeric.normals[e]
            bar = 0.3 * f_t * numeric.tangents[e] * numeric.radii.min()
            ax.plot(*np.array([touch - bar, touch + bar]).T, color="k", lw=2, zorder=3)
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_axis_off()
    ax.set_title(network.name, fontsize=9)
    return ax
