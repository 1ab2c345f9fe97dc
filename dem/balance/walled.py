"""Equilibrium between walls, under weight: walls are bodies of the balance, after the grains.

With N grains and w walls y has 3 (N + w) + 1 entries. A wall moves along its normal n_w only, by
one number h, and with it the grains glued to it: y = P h̃ with the entry of h at the wall's first
place, and

    R̃ = Pᵀ (M f + F_ext) ,     dR̃/dh̃ = Pᵀ (dR/dy) P ,     F_ext = -m g, and -load n_w on a wall

Held walls, glued grains and the strain of the cell have no column in P. A wall contact keeps its
direction: its force does not turn with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array

from dem.balance.blocks import GrainBlocks, Response
from dem.balance.bodies import wall_branches, with_walls
from dem.balance.contact_forces import ContactForces
from dem.balance.tangent import PIN, Equilibrium
from dem.balance.trial import Trial
from dem.model.drive import Drive
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.state import State
from packing.arguments.arrays import Floats
from packing.contacts.dissection import nested_dissection
from packing.contacts.rattlers import backbone, fewest_contacts


@dataclass(frozen=True)
class WalledTrial(Trial):
    """With the loads on grains and walls, and the freedom ``P`` of these."""

    freedom: csr_array
    external: Floats

    def residual(self, normal: Floats, tangential: Floats) -> Floats:
        """Pᵀ (M f + F_ext), (3 (N + w) + 1,)."""
        return self.freedom.T @ (self.resultants(normal, tangential) + self.external)


class WalledEquilibrium(Equilibrium):
    """``Equilibrium`` of grains between walls, or under their weight, in a cell that stays."""

    def __init__(
        self, state: State, near: Neighbours, law: ContactLaw, pressure: float, drive: Drive
    ) -> None:
        self.state, self.drive = state, drive
        self.grains = len(state.radii)
        self.inner = len(near.pairs)
        super().__init__(state, with_walls(near, state), law, pressure)
        at_wall = np.arange(len(self.near.pairs)) >= self.inner
        self.direction = np.where(at_wall, self.start / np.abs(self.start), 0.0)
        if state.walls is not None:
            self.friction = np.where(at_wall, state.walls.friction, law.friction)

    def bodies(self, state: State) -> int:
        """Grains and walls."""
        return self.grains + (0 if state.walls is None else len(state.walls.masses))

    def starting_branches(self, state: State) -> np.ndarray:
        """Branches, those of wall contacts along the normals."""
        near, moving = self.near, state.walls
        inner = slice(0, self.inner)
        i, j = near.columns[:, inner]
        z = state.positions.view(complex)[:, 0]
        branch = z[j] - z[i] + near.shift[inner]
        if moving is None:
            return branch
        return np.append(branch, wall_branches(near, moving, z))

    @cached_property
    def freedom(self) -> csr_array:
        """P, square, with columns of zeros for what does not move."""
        state, count = self.state, self.count
        moving = state.walls
        diagonal = np.ones(3 * count + 1)
        diagonal[-1] = 0.0
        rows, columns, values = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)]
        if moving is not None:
            walls = self.grains + np.arange(len(moving.masses))
            stuck, stuck_to = moving.glued(self.grains)
            for k in range(3):
                diagonal[k * count + np.append(walls, stuck)] = 0.0
            free = np.flatnonzero(moving.free)
            carried = np.flatnonzero(moving.free[stuck_to])
            body = np.concatenate([walls[free], stuck[carried]])
            of = np.concatenate([free, stuck_to[carried]])
            for k in (0, 1):
                rows.append(k * count + body)
                columns.append(walls[of])
                values.append(moving.walls.normals[of, k])
        where = (np.concatenate(rows), np.concatenate(columns))
        shape = (len(diagonal), len(diagonal))
        along = csr_array((np.concatenate(values), where), shape=shape)
        return csr_array(diags_array(diagonal) + along)

    @cached_property
    def external(self) -> Floats:
        """Weight on grains, loads on free walls (3 (N + w) + 1,)."""
        out, count, moving = np.zeros(3 * self.count + 1), self.count, self.state.walls
        weight = np.zeros(count)
        weight[: self.grains] = -self.drive.gravity * self.state.masses
        if moving is not None:
            weight[moving.glued(self.grains)[0]] = 0.0
        out[count : 2 * count] = weight
        if moving is not None:
            load = np.where(moving.free, moving.walls.loads, 0.0)
            for k in (0, 1):
                out[k * count + self.grains + np.arange(len(load))] = (
                    -load * moving.walls.normals[:, k]
                )
        return out

    def trial(self, y: Floats) -> Trial:
        """Forces after the moves ``y``, with the loads."""
        return WalledTrial(**vars(super().trial(y)), freedom=self.freedom, external=self.external)

    def bearing(self, bearing: np.ndarray) -> np.ndarray:
        """Walls, glued grains and all that weighs something is no rattler."""
        held = np.full(self.count, self.drive.gravity > 0)
        held[self.grains :] = True
        if self.state.walls is not None:
            held[self.state.walls.glued(self.grains)[0]] = True
        few = fewest_contacts(self.rotates)
        return backbone(self.near.pairs, bearing, self.count, few, held=held)

    def branches(self, y: Floats) -> tuple[np.ndarray, Floats, Floats]:
        """A wall contact stays along its normal, whatever the grain does along the wall."""
        d, overlap, aside = super().branches(y)
        n = self.direction[self.inner :]
        along = (d[self.inner :] * n.conj()).real
        d[self.inner :] = along * n
        overlap[self.inner :] = self.near.sigma[self.inner :] - along
        return d, overlap, aside

    def response(self, trial: Trial) -> Response:
        """Forces of wall contacts do not turn."""
        found = super().response(trial)
        turns = np.arange(len(self.near.pairs)) < self.inner
        return replace(
            found,
            turning_normal=found.turning_normal * turns,
            turning_tangential=found.turning_tangential * turns,
        )

    def tangent(self, trial: Trial) -> csc_array:
        """dR̃/dh̃, rows and columns of zeros for what does not move."""
        P = self.freedom
        return csc_array(P.T @ super().tangent(trial) @ P)

    def factorise(self, trial: Trial, shift: Floats | float = PIN) -> Callable[[Floats], Floats]:
        """Sparse LU of Pᵀ (tangent - shift κ) P: residual -> Newton step, which P allows."""
        response, place = self.response(trial), self.blocks.place
        border = self._border(trial, response)
        matrix = self.blocks.matrix(trial, response, border, shift * self.stiffness)
        P = csr_array(self.freedom[place][:, place])
        still = (np.asarray(abs(P).sum(axis=0)).ravel() == 0) * -self.stiffness
        solve = self.blocks.solver(csc_array(P.T @ matrix @ P + diags_array(still)))
        return lambda residual: self.freedom @ -solve(residual)

    @cached_property
    def blocks(self) -> GrainBlocks:
        """Grains in the order of a dissection of their contacts, walls last."""
        touching = (self.near.sigma > np.abs(self.start))[: self.inner]
        z = self.near.origin
        inside = np.column_stack([z.real, z.imag]) % self.near.sides
        order = nested_dissection(inside, self.near.pairs[: self.inner][touching])
        walls = np.arange(self.grains, self.count)
        return GrainBlocks(np.append(order, walls), 3 if self.rotates else 2)

    def put(self, state: State, y: Floats, forces: ContactForces) -> None:
        """Grains, walls and history of ``state`` after the moves ``y``."""
        u = self.displacement(y)
        z = state.positions.view(complex)[:, 0] + u[: self.grains]
        state.positions = np.column_stack([z.real, z.imag])
        if state.walls is not None:
            moving = state.walls
            moved = (u[self.grains :] * moving.normals.conj()).real
            state.walls = moving.moved(moving.walls.offsets + moved, np.zeros(len(moved)))
        overlaps = np.maximum(self.branches(y)[1], 0.0)
        self.near.elongation[:] = self.law.elongation(forces.tangential, overlaps)
        state.history = self.near.history()
        state.reached = None
