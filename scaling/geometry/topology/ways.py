"""The ways through the contacts of which one component closes are found: `topology.lines`."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import boundary_of
from packing.boundary.walled import Walled
from packing.boundary.walls import Walls
from scaling.geometry.topology.lines import Collected, Lines
from scaling.geometry.topology.paths import Paths
from scaling.geometry.topology.spanning_forest import Forest
from scaling.geometry.topology.windings import loop_through
from scaling.geometry.topology.wiring import Wiring


@dataclass(frozen=True)
class Places:
    """Where grains and walls were when contacts were listed, and the contacts with walls."""

    positions: Floats | None
    cell: Floats | None
    walls: Walls | None
    wall_pairs: Integers
    """(k, 2) grain and wall of each contact with a wall."""


def lines(wiring: Wiring, forest: Forest, places: Places) -> Lines:
    """Those that need no absolute length: wall pairs, ribbons, glued pairs."""
    inner, walls = wiring.contacts, places.walls
    found = Collected(inner + len(places.wall_pairs))
    told: list[int] = []
    if walls is not None:
        if places.positions is None:
            raise ValueError("walls need positions: which contacts on a wall are neighbours?")
        paths = Paths(wiring)
        for w in range(len(walls)):
            told += _wall_pairs(found, w, wiring, forest, places, paths)
        if walls.spaced and walls.glued is not None:
            _glued_pairs(found, forest, places, paths)
    for component in _ribbons(forest):
        if component not in told:
            contacts, signs, image = _round(wiring, forest, component)
            across = np.array([[0, -1], [1, 0]]) @ _unit(image, places)
            found.add("ribbon", contacts, signs, across, image)
    return found.lines(repeated=len(told) - len(set(told)))


def spans(wiring: Wiring, forest: Forest, places: Places) -> Lines:
    """Those that need one: the length of the cell along a ribbon, the distance of two walls."""
    inner, walls = wiring.contacts, places.walls
    found = Collected(inner + len(places.wall_pairs))
    for component in _ribbons(forest):
        contacts, signs, image = _round(wiring, forest, component)
        found.add("span", contacts, signs, _unit(image, places), image)
    if walls is None:
        return found.lines()
    boundary, paths = boundary_of(places.cell, walls), Paths(wiring)
    assert isinstance(boundary, Walled)
    grain, wall = places.wall_pairs.T
    for a, b, _ in boundary.clearances():
        one, other = np.flatnonzero(wall == a), np.flatnonzero(wall == b)
        for label in np.intersect1d(forest.component[grain[one]], forest.component[grain[other]]):
            first, last = (k[forest.component[grain[k]] == label][0] for k in (one, other))
            contacts, signs = paths.between(int(grain[first]), int(grain[last]))
            contacts = np.concatenate([contacts, [inner + first, inner + last]])
            signs = np.concatenate([signs, [-1, 1]])
            found.add("span", contacts, signs, walls.normals[b], walls=(a, b))
    return found.lines()


def _wall_pairs(
    found: Collected, w: int, wiring: Wiring, forest: Forest, places: Places, paths: Paths
) -> list[int]:
    """Add the pairs of wall `w`; labels of the components that wind along it."""
    assert places.walls is not None
    assert places.positions is not None
    inner, told = wiring.contacts, []
    n = places.walls.normals[w]
    mine = np.flatnonzero(places.wall_pairs[:, 1] == w)
    grain = places.wall_pairs[mine, 0]
    s, turn = places.positions[grain] @ np.array([-n[1], n[0]]), np.zeros(len(mine), dtype=int)
    sense = 1
    if places.cell is not None:
        along = places.cell[0] @ np.array([-n[1], n[0]])
        sense, length = int(np.sign(along)), abs(along)
        turn = np.floor(s / length).astype(int)
        s = s - turn * length
    for label in np.unique(forest.component[grain]):
        k = np.flatnonzero(forest.component[grain] == label)
        k = k[np.argsort(s[k], kind="stable")]
        winds = forest.winding_rank[label] > 0
        if winds:
            told.append(int(label))
        for a, b, wrap in _neighbours(k, winds):
            image = sense * (wrap - turn[b] + turn[a])
            if not wiring.periodic:
                image = 0
            elif not winds:
                image = int((forest.shift[grain[b]] - forest.shift[grain[a]])[0])
            contacts, signs = paths.between(int(grain[a]), int(grain[b]), image)
            contacts = np.concatenate([contacts, [inner + mine[a], inner + mine[b]]])
            signs = np.concatenate([signs, [-1, 1]])
            found.add("wall", contacts, signs, n)
    return told


def _neighbours(k: Integers, round_: bool) -> list[tuple[int, int, int]]:
    """(this, next, 1 if the cell is crossed between them)."""
    pairs = [(int(a), int(b), 0) for a, b in pairwise(k)]
    return [*pairs, (int(k[-1]), int(k[0]), 1)] if round_ else pairs


def _glued_pairs(found: Collected, forest: Forest, places: Places, paths: Paths) -> None:
    """Two rows for each grain glued to a wall and the next one of its component."""
    assert places.walls is not None
    assert places.positions is not None
    glued = places.walls.glued_grains(len(places.positions))
    touched = np.zeros(len(glued), dtype=bool)
    touched[paths.wiring.pairs] = True
    for w in range(len(places.walls)):
        n = places.walls.normals[w]
        s = places.positions @ np.array([-n[1], n[0]])
        stuck = np.flatnonzero((glued == w) & touched)
        for label in np.unique(forest.component[stuck]):
            k = stuck[forest.component[stuck] == label]
            k = k[np.argsort(s[k], kind="stable")]
            for a, b in pairwise(k.tolist()):
                contacts, signs = paths.between(a, b)
                for d in np.eye(2):
                    found.add("glued", contacts, signs, d, grains=(a, b))


def _ribbons(forest: Forest) -> list[int]:
    return np.flatnonzero(forest.winding_rank == 1).tolist()


def _round(wiring: Wiring, forest: Forest, component: int) -> tuple[Integers, Integers, Integers]:
    """(contacts, ±1, winding) of a loop round the cell, of the smallest winding there is."""
    mine = forest.component[wiring.pairs[:, 0]] == component
    size = np.abs(forest.winding).sum(axis=1)
    through = np.flatnonzero(mine & (size > 0))
    contact = int(through[np.argmin(size[through])])
    signs = loop_through(wiring, forest, contact)
    on = np.flatnonzero(signs)
    return on, signs[on], forest.winding[contact]


def _unit(image: Integers, places: Places) -> Floats:
    assert places.cell is not None
    Λ = image @ places.cell
    return Λ / np.linalg.norm(Λ)
