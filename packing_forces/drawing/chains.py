"""Force chains: grains as circles, contacts as lines as wide as their force, walls as strokes.

A periodic cell is drawn once, with what leaves it on one side and comes in on the other. Normal
forces that push and that pull have colours of their own; the widest line is four times the mean.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import instance, positive_number
from packing.boundary.walls import FREE, Walls
from packing_forces.drawing.copies import copies_within
from packing_forces.drawing.window import discs, segments
from scaling import CoarseCoordinatesWarning, ContactNetwork

PUSH, PULL = "#0072B2", "#D55E00"
CLIP = 4.0
"""Widest line, in mean normal forces."""
WIDTH = 0.22
"""Of the line of a mean force, in mean diameters, so that it does not depend on the page."""
GRAIN, GLUED, EDGE, WALL = "0.95", "0.75", "0.7", "0.25"


def plot(
    network: Any,
    forces: Any = None,
    *,
    axes: Axes | None = None,
    values: ArrayLike | None = None,
    label: str = "",
    scale: float | None = None,
) -> Axes:
    """Draw a packing with its force chains.

    Parameters
    ----------
    network : ContactNetwork or object
        A network, or anything with positions, radii and pairs: a `Packing`, a `Measurement`
    forces : object or array_like, optional
        A reconstruction, a packing, or an array (c,) or (2c,), normal forces first; left out,
        those of a packing, or lines of one width
    axes : matplotlib.axes.Axes, optional
        Where to draw; left out, a new figure
    values : (c,) array_like, optional
        A number for each contact, drawn as its colour: an error, say
    label : str
        What the values are
    scale : float, optional
        Force of a line of mean width; left out, the mean of |f_n|

    Returns
    -------
    matplotlib.axes.Axes
        Whose `figure` can be saved.

    Raises
    ------
    ValueError
        Another number of forces or values than of contacts, a network without positions.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from packing_forces import plot
    >>> from scaling import CoarseCoordinatesWarning, ContactNetwork
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)])
    >>> axes = plot(pair, [1.0], axes=Figure().subplots())
    >>> len(axes.collections)
    2
    """
    if forces is None:
        forces = getattr(network, "normal_forces", None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CoarseCoordinatesWarning)  # a picture computes no force
        net = ContactNetwork.from_packing(network)
    if net.positions is None:
        raise ValueError("plot needs positions: this network has directions only")
    normal = None if forces is None else _normal(forces, net.contacts)
    mean = 1.0 if normal is None or not normal.any() else float(np.abs(normal).mean())
    if scale is not None:
        mean = positive_number("scale", scale)
    strength = np.full(net.contacts, 0.3) if normal is None else np.abs(normal) / mean
    pulls = np.zeros(net.contacts, bool) if normal is None else normal < 0
    colours: dict[str, Any] = {"colors": np.where(pulls, PULL, PUSH)}
    if values is not None:
        colours = {
            "array": real_array("values", values, (net.contacts,), "contact"),
            "cmap": "viridis_r",
        }
    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.subplots(layout="constrained")[1]
    else:
        instance("axes", axes, Axes)
    lines = _draw(axes, net, strength, colours)
    if values is not None and axes.figure is not None:
        axes.figure.colorbar(lines, ax=axes, shrink=0.8, pad=0.02, label=label)
    return axes


def _normal(forces: Any, contacts: int) -> Floats:
    """(c,) normal forces of a reconstruction, a packing or an array."""
    f = real_array("forces", getattr(forces, "forces", forces), (None,), "component")
    if len(f) not in (contacts, 2 * contacts):
        raise ValueError(
            f"forces: {len(f)} numbers for {contacts} contacts; expected {contacts} normal "
            f"forces, or {2 * contacts} with the tangential ones"
        )
    return f[:contacts]


def _draw(axes: Axes, net: ContactNetwork, strength: Floats, colours: dict[str, Any]) -> Any:
    """Grains, contacts, walls and frame; the lines are returned."""
    assert net.positions is not None
    x, radii, unit = net.positions, net.radii, net.mean_diameter
    starts, branches = x[np.minimum(net.pairs[:, 0], net.grains - 1)], _branches(net)
    low, high, corners = _extent(net, x)
    clip = None if net.cell is None else Polygon(corners, transform=axes.transData)
    margin = float(radii.max())
    index, places = copies_within(x, net.cell, low - margin, high + margin)
    glued = np.full(net.grains, FREE) if net.walls is None else net.walls.glued_grains(net.grains)
    shades = np.where(glued == FREE, GRAIN, GLUED)[index]
    circles = discs(places, radii[index], facecolors=list(shades), edgecolor=EDGE)
    reach = float(np.abs(branches).max(initial=0.0))
    which, ends = copies_within(starts, net.cell, low - reach, high + reach)
    mine = {k: v[which] if isinstance(v, np.ndarray) else v for k, v in colours.items()}
    width = _points(axes, high - low) * WIDTH * unit
    lines = segments(
        ends, branches[which], linewidths=width * np.minimum(strength, CLIP)[which], **mine
    )
    for collection in (circles, lines):
        axes.add_collection(collection)
        if clip is not None:
            collection.set_clip_path(clip)
    if clip is not None:
        axes.add_patch(Polygon(corners, fill=False, edgecolor=EDGE, linewidth=0.6, linestyle=":"))
    if net.walls is not None:
        _strokes(axes, net.walls, low, high)
    pad = 0.02 * (high - low)
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.set_xlim(low[0] - pad[0], high[0] + pad[0])
    axes.set_ylim(low[1] - pad[1], high[1] + pad[1])
    return lines


def _branches(net: ContactNetwork) -> Floats:
    """From the first grain to the second, or to the foot on the wall, (c, 2)."""
    return net.distances[:, None] * net.normals


def _extent(net: ContactNetwork, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Lower and upper corner of what is drawn, and the corners of the cell (4, 2)."""
    if net.cell is None:
        reach = net.radii[:, None]
        low, high = (x - reach).min(axis=0), (x + reach).max(axis=0)
        return low, high, np.array([low, high])
    along = x @ np.linalg.inv(net.cell)
    # Wrapped coordinates fill one cell, and that is the one to draw.
    wrapped = np.all(np.ptp(along, axis=0) < 1)
    first = along.min(axis=0) if wrapped else np.zeros(2)
    origin = first @ net.cell
    a, b = net.cell
    corners = origin + np.array([0 * a, a, a + b, b])
    low, high = corners.min(axis=0), corners.max(axis=0)
    if net.walls is not None:  # they bound the grains across the period
        reach = net.radii[:, None]
        low[1], high[1] = (x - reach)[:, 1].min(), (x + reach)[:, 1].max()
        corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    return low, high, corners


def _points(axes: Axes, size: Floats) -> float:
    """Points of the page for a unit of length."""
    box = axes.get_window_extent()
    dpi = 72.0 if axes.figure is None else float(axes.figure.get_dpi())
    return 72 / dpi * min(box.width / size[0], box.height / size[1])


def _strokes(axes: Axes, walls: Walls, low: Floats, high: Floats) -> None:
    """Each wall as far as the packing reaches along it."""
    middle, half = (low + high) / 2, np.linalg.norm(high - low) / 2
    for n, offset, t in zip(walls.normals, walls.offsets, walls.tangents, strict=True):
        foot = middle + (offset - n @ middle) * n
        across = abs(n) @ (high - low)
        length = min(half, abs(t) @ (high - low) / 2)
        if abs(offset - n @ middle) < across:  # one that is far away would shrink the rest
            ends = np.array([foot - length * t, foot + length * t])
            axes.plot(*ends.T, color=WALL, linewidth=1.2)
