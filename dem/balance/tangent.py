"""Equilibrium of the listed contacts at trial positions, and its consistent tangent.

With y = (δx, R δθ, ℓ ε) the moves of the grains and the strain of the cell (``dem.balance.trial``)
a contact changes by δr = M_nᵀ y, δq = -M_tᵀ y (slip) and δτ = -Tᵀ y (sideways; T = M_t without
torque rows), and the residual R = M f - (0 ; 2 p A/ℓ) by

    dR = M_n df_n + N f_t δτ/r + M_t df_t - T f_n δτ/r + (0 ; (Σ f_n δr - 4 p A ε)/ℓ),
    N = M_n without its cell row,
    df_n = -f'(δ) δr;   df_t = k_t δq if the contact sticks, ± μ df_n if it slides;

f' = κ of linear springs.  Where k_t changes with the overlap, incremental laws (Hertz and Mindlin)
have the part of df_t/dδr that goes with it, on the branch, loading or unloading since the start,
on which the contact is; of others that change is left out: Newton's method then ends no worse,
but converges linearly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array

from dem.balance.blocks import Border, GrainBlocks, Response
from dem.balance.contact_forces import ContactForces, bearing_contacts
from dem.balance.trial import Trial
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import rectangle
from dem.motion.state import State
from packing.arguments.arrays import Floats
from packing.contacts.dissection import nested_dissection

#: Smallest diagonal shift, in units of κ: it pins the two translations of the whole packing.
PIN = 1e-13


class Equilibrium:
    """The force balance of one contact list as a function of the moves y ``(3N + 1,)``."""

    def __init__(self, state: State, near: Neighbours, law: ContactLaw, pressure: float) -> None:
        self.near, self.pressure = near, pressure
        self.law = law if law.linear else law.of(near.effective_radii)
        self.count = self.bodies(state)
        self.friction: Floats | float = law.friction
        self.rotates = law.friction > 0
        self.span = float(np.sqrt(self.count))  # ℓ, so that the cell's row is like a grain's
        self.area = float(np.prod(near.sides)) * near.scale(state) ** 2
        self.scale = near.scale(state)
        self.start = self.starting_branches(state)
        self.overlap = np.maximum(near.sigma - np.abs(self.start), 0.0)
        deepest = float(self.overlap.max(initial=0.0))
        #: The unit κ of stiffness: that of the deepest contact.
        self.stiffness = float(law.slope(np.array([deepest]))[0])

    def bodies(self, state: State) -> int:
        """What balances: the grains."""
        return len(state.radii)

    def starting_branches(self, state: State) -> np.ndarray:
        """Branches (complex) of the listed contacts where the grains are."""
        return self.near.branches(state)

    def bearing(self, bearing: np.ndarray) -> np.ndarray:
        """Of contacts ``bearing`` those left when rattlers are taken off."""
        return bearing_contacts(self.near, bearing, self.law, self.count)

    def put(self, state: State, y: Floats, forces: ContactForces) -> None:
        """Positions, cell and history of ``state`` after the moves ``y``."""
        z = state.positions.view(complex)[:, 0] * self.stretch(y) + self.displacement(y)
        state.positions = np.column_stack([z.real, z.imag])
        state.cell = rectangle(self.near.sides * self.scale * self.stretch(y))
        overlaps = np.maximum(self.branches(y)[1], 0.0)
        self.near.elongation[:] = self.law.elongation(forces.tangential, overlaps)
        state.history = self.near.history()
        state.reached = None

    def as_integrated(self) -> ContactForces:
        """What time integration has left at the contacts."""
        normal = self.law.force(self.overlap)
        k_t = self.law.tangential_stiffness(self.overlap)
        return ContactForces(normal, k_t * self.near.elongation, self.bearing(normal > 0))

    def trial(self, y: Floats) -> Trial:
        """Forces after the moves ``y``, history counted from the start."""
        law, near, count = self.law, self.near, self.count
        i, j = near.columns
        turn = y[2 * count : -1]
        d, overlap, aside = self.branches(y)
        overlap = np.maximum(overlap, 0.0)
        pushing = law.force(overlap)
        bearing = self.bearing(pushing > 0)
        normal = np.where(bearing, pushing, 0.0)
        k_t = law.tangential_stiffness(overlap)
        held = near.elongation
        if law.incremental:
            held = held * law.kept(self.overlap, overlap)
        sprung = k_t * (held + (aside - turn[i] - turn[j]))
        cap = self.friction * normal
        return Trial(
            near, y, d, overlap, normal, np.clip(sprung, -cap, cap),
            bearing, bearing & (np.abs(sprung) >= cap), self.span,
            load=2 * self.pressure * self.area * self.stretch(y) ** 2 / self.span,
        )  # fmt: skip

    def without(self, trial: Trial, opened: np.ndarray) -> Trial:
        """``trial`` with the contacts ``opened`` bearing nothing, nor what falls with them."""
        bearing = self.bearing(trial.bearing & ~opened)
        return replace(
            trial,
            normal=np.where(bearing, trial.normal, 0.0),
            tangential=np.where(bearing, trial.tangential, 0.0),
            bearing=bearing,
            sliding=trial.sliding & bearing,
        )

    def stretch(self, y: Floats) -> float:
        """Size of the cell after ``y``, in units of that at the start."""
        return float(1 + y[-1] / self.span)

    def displacement(self, y: Floats) -> np.ndarray:
        """The moves of the centres, complex ``(N,)``."""
        return y[: self.count] + 1j * y[self.count : 2 * self.count]

    def branches(self, y: Floats) -> tuple[np.ndarray, Floats, Floats]:
        """Branch vectors (complex), overlaps, and displacements across the starting branch.

        From the moves, not from the moved positions: these are rounded to ε L, and soft packings
        turn that noise into moves that no longer are small.
        """
        i, j = self.near.columns
        u = self.displacement(y)
        d = self.start * self.stretch(y) + (u[j] - u[i])
        aside = (d * (self.start / np.abs(self.start)).conj()).imag
        return d, self.near.sigma - np.abs(d), aside

    def response(self, trial: Trial) -> Response:
        """df_n/dδr, df_t/dδq and df_t/dδr of every contact, and what turning it does."""
        law = self.law
        on_normal = np.where(trial.bearing, -law.slope(trial.overlap), 0.0)
        sticks = trial.bearing & ~trial.sliding
        k_t = law.tangential_stiffness(trial.overlap)
        on_slip = np.where(sticks & self.rotates, k_t, 0.0)
        slides = (
            self.friction * np.sign(trial.tangential) * np.where(trial.sliding, on_normal, 0.0)
        )
        if law.incremental:
            slides = np.where(sticks, self._unloading(trial), slides)
        r = trial.r
        return Response(on_normal, on_slip, slides, trial.normal / r, trial.tangential / r)

    def _unloading(self, trial: Trial) -> Floats:
        """df_t/dδr of contacts that stick: of k_t ∝ √δ half of f_t/δ, where a contact loads
        without what it bore at the start."""
        loads = trial.overlap > self.overlap
        before = self.law.tangential_stiffness(self.overlap) * self.near.elongation
        grows = trial.tangential - np.where(loads, before, 0.0)
        return -0.5 * np.divide(
            grows, trial.overlap, out=np.zeros_like(grows), where=trial.bearing
        )

    def _border(self, trial: Trial, response: Response) -> Border:
        """Row, column and corner of the cell."""
        stretch = trial.r / self.span
        column = trial.resultants(response.normal * stretch, response.slide * stretch)
        # Turning changes the direction of a force, hence the grains' rows, not Σ f_n r.
        pushed = response.normal * stretch + trial.normal / self.span
        row = trial.resultants(pushed, np.zeros(len(pushed)))
        return Border(row, column, float(row[-1] - 2 * trial.load / self.span))

    def tangent(self, trial: Trial) -> csc_array:
        """dR/dy ``(3N + 1, 3N + 1)``; rows of rotation are 0 without friction."""
        response = self.response(trial)
        matrix = self.blocks.matrix(trial, response, self._border(trial, response))
        return self.blocks.in_layout_of_moves(matrix)

    def factorise(self, trial: Trial, shift: Floats | float = PIN) -> Callable[[Floats], Floats]:
        """Sparse LU of the tangent minus ``shift`` κ (per grain): residual -> Newton step.

        Rattlers stay: nothing pulls at them.
        """
        response = self.response(trial)
        border = self._border(trial, response)
        matrix = self.blocks.matrix(trial, response, border, shift * self.stiffness)
        solve = self.blocks.solver(matrix)
        return lambda residual: -solve(residual)

    @cached_property
    def blocks(self) -> GrainBlocks:
        """Grains in the order of a dissection of the contacts at the start."""
        touching = self.near.sigma > np.abs(self.start)
        z = self.near.origin
        inside = np.column_stack([z.real, z.imag]) % self.near.sides
        order = nested_dissection(inside, self.near.pairs[touching])
        return GrainBlocks(order, 3 if self.rotates else 2)
