"""A picture in one line: every contact once, as wide as its force, walls and copies included."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.figure import Figure

import packing_forces
from dem import Scene, relax
from packing_forces.drawing.chains import CLIP, PULL, PUSH
from packing_forces.drawing.copies import copies_within
from scaling import ContactNetwork, reconstruct
from tests.conftest import packing


def drawn(*arguments, **more):
    return packing_forces.plot(*arguments, axes=Figure().subplots(), **more)


def lines_of(axes):
    (lines,) = (c for c in axes.collections if isinstance(c, LineCollection))
    return lines


def test_widths_are_forces_and_colours_signs():
    """An open chain of three: forces 1, -2 of mean 1.5; widths in the ratio 1 to 2."""
    chain = ContactNetwork([[0, 0], [1, 0], [2, 0]], [0.5] * 3, [(0, 1), (1, 2)])
    lines = lines_of(drawn(chain, [1.0, -2.0]))
    thin, thick = lines.get_linewidths()
    assert thick == pytest.approx(2 * thin)
    from matplotlib.colors import to_rgba

    assert [tuple(c) for c in lines.get_colors()] == [to_rgba(PUSH), to_rgba(PULL)]
    strong = lines_of(drawn(chain, [1.0, 1e6], scale=1.0)).get_linewidths()
    assert strong[1] == pytest.approx(CLIP * strong[0])


def test_packing_reconstruction_and_arrays_draw_the_same():
    p = packing(grains=40, delta=1e-3)
    n = ContactNetwork.from_packing(p)
    widths = [
        np.array(lines_of(drawn(*args)).get_linewidths())
        for args in ((p,), (n, p), (n, p.normal_forces), (n, reconstruct(n, p.stiffness)))
    ]
    for other in widths[1:]:
        assert other == pytest.approx(widths[0], rel=1e-6)


def test_a_periodic_cell_is_full():
    """What leaves on one side comes in on the other: more lines than contacts, grains likewise."""
    p = packing(grains=40, delta=1e-3)
    axes = drawn(p)
    assert len(lines_of(axes).get_segments()) > len(p.pairs)
    (grains,) = (c for c in axes.collections if isinstance(c, PatchCollection))
    assert len(grains.get_paths()) > len(p.radii)
    opened = ContactNetwork.from_packing(p).inside(np.arange(5), p.normal_forces)
    axes = drawn(opened, np.ones(opened.contacts))
    assert len(lines_of(axes).get_segments()) == opened.contacts


def test_copies_of_a_sheared_lattice():
    """Against all copies within nine cells, of points anywhere."""
    rng = np.random.default_rng(2)
    lattice, points = np.array([[3.0, 0.2], [-1.4, 2.0]]), 20 * rng.standard_normal((30, 2))
    low, high = np.array([-4.0, 1.0]), np.array([3.0, 6.0])
    index, places = copies_within(points, lattice, low, high)
    base = points - np.floor(points @ np.linalg.inv(lattice)) @ lattice
    k = np.arange(-9, 10)
    shifts = np.stack(np.meshgrid(k, k), -1).reshape(-1, 2) @ lattice
    everywhere = (base[None] + shifts[:, None]).reshape(-1, 2)
    inside = everywhere[np.all((everywhere > low) & (everywhere < high), axis=1)]
    assert len(places) == len(inside)
    assert np.sort(places.sum(axis=1)) == pytest.approx(np.sort(inside.sum(axis=1)))
    steps = (places - points[index]) @ np.linalg.inv(lattice)
    assert np.abs(steps - np.rint(steps)).max() < 1e-12


def test_walls_are_strokes_and_their_contacts_end_on_them():
    p = relax(Scene(40, 1e-2, boundary="box"), seed=1, progress=False)
    axes = drawn(p)
    assert len(axes.lines) == 4
    ends = np.array([s[1] for s in lines_of(axes).get_segments()])
    at_walls = p.pairs[:, 1] >= len(p.radii)
    wall = p.pairs[at_walls, 1] - len(p.radii)
    gaps = np.sum(ends[at_walls] * p.walls.normals[wall], axis=1) - p.walls.offsets[wall]
    assert np.abs(gaps).max() < 1e-9


def test_values_are_colours_with_a_bar():
    p = packing(grains=40, delta=1e-3)
    values = np.linspace(0, 1, len(p.pairs))
    axes = drawn(p, values=values, label="error")
    assert set(np.asarray(lines_of(axes).get_array())) == set(values)
    assert axes.figure.axes[-1].get_ylabel() == "error"


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"forces": np.ones(3)}, "3 numbers for"),
        ({"values": np.ones(3)}, "values"),
        ({"scale": -1.0}, "scale"),
        ({"axes": "mine"}, "axes"),
    ],
)
def test_wrong_arguments_are_named(more, message):
    with pytest.raises(ValueError, match=message):
        packing_forces.plot(packing(grains=40, delta=1e-3), **more)


def test_directions_alone_cannot_be_drawn():
    pair = ContactNetwork(None, [0.5, 0.5], [(0, 1)], normals=[[1.0, 0.0]])
    with pytest.raises(ValueError, match="plot needs positions"):
        packing_forces.plot(pair)
