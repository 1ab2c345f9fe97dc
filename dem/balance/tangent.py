"""Equilibrium of the listed contacts at trial positions, and its consistent tangent.

With M the equilibrium matrix (one column per force, torque rows over R, a last row for the
cell) and y = (δx, R δθ, ℓ ε) the moves of the grains and the strain of the cell, a contact
changes by

    δr = M_nᵀ y,   δq = -M_tᵀ y (slip),   δτ = -Tᵀ y (sideways; T = M_t without torque rows)

and the residual R = M f - (0 ; 2 p A/ℓ) by

    dR = M_n df_n + N f_t δτ/r + M_t df_t - T f_n δτ/r + (0 ; (Σ f_n δr - 4 p A ε)/ℓ),
    N = M_n without its cell row,
    df_n = -f'(δ) δr;   df_t = k_t δq if the contact sticks, ± μ df_n if it slides;

f' = κ of linear springs.  Where k_t changes with the overlap that change is left out: Newton's
method then ends no worse, but converges linearly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu

from dem.balance.contact_forces import bearing_contacts
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import sides_of
from dem.motion.state import State
from packing.arguments.arrays import Floats

#: Smallest diagonal shift, in units of κ: it pins the two translations of the whole packing.
PIN = 1e-13


@dataclass(frozen=True)
class Trial:
    """Contacts and forces after the moves ``y``; ``load`` is 2 p A/ℓ; R = M f - load."""

    y: Floats
    r: Floats
    overlap: Floats
    normal: Floats
    tangential: Floats
    bearing: np.ndarray
    sliding: np.ndarray
    m_n: csr_array
    m_t: csr_array
    sideways: csr_array
    load: float

    def residual(self, normal: Floats, tangential: Floats) -> Floats:
        """M f - (0 ; load) for forces on these contacts ``(3N + 1,)``."""
        out = self.m_n @ normal + self.m_t @ tangential
        out[-1] -= self.load
        return out


class Equilibrium:
    """The force balance of one contact list as a function of the moves y ``(3N + 1,)``."""

    def __init__(self, state: State, near: Neighbours, law: ContactLaw, pressure: float) -> None:
        assert state.cell is not None
        self.near, self.law, self.pressure = near, law, pressure
        self.count = len(state.radii)
        self.rotates = law.friction > 0
        self.span = float(np.sqrt(self.count))  # ℓ, so that the cell's row is like a grain's
        self.area = float(np.prod(sides_of(state.cell)))
        self.scale = near.scale(state)
        self.start = near.branches(state)
        deepest = float((near.sigma - np.abs(self.start)).max(initial=0.0))
        #: The unit κ of stiffness: that of the deepest contact.
        self.stiffness = float(law.slope(np.array([deepest]))[0])

    def trial(self, y: Floats) -> Trial:
        """Forces after the moves ``y``, history counted from the start."""
        law, near, count = self.law, self.near, self.count
        i, j = near.columns
        turn = y[2 * count : -1]
        d, overlap, aside = self.branches(y)
        r = np.abs(d)
        overlap = np.maximum(overlap, 0.0)
        pushing = law.force(overlap)
        bearing = bearing_contacts(near, pushing > 0, law, count)
        normal = np.where(bearing, pushing, 0.0)
        k_t = law.tangential_stiffness(overlap)
        sprung = k_t * (near.elongation + (aside - turn[i] - turn[j]))
        cap = law.friction * normal
        return Trial(
            y, r, overlap, normal, np.clip(sprung, -cap, cap),
            bearing, bearing & (np.abs(sprung) >= cap), *self._columns(d / r, r),
            load=2 * self.pressure * self.area * self.stretch(y) ** 2 / self.span,
        )  # fmt: skip

    def without(self, trial: Trial, opened: np.ndarray) -> Trial:
        """``trial`` with the contacts ``opened`` bearing nothing, nor what falls with them."""
        bearing = bearing_contacts(self.near, trial.bearing & ~opened, self.law, self.count)
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

    def _columns(self, n: np.ndarray, r: Floats) -> tuple[csr_array, csr_array, csr_array]:
        """M_n with the cell's row, M_t, and M_t without its torque rows; ``(3N + 1, c)``."""
        i, j = self.near.columns
        count, e = self.count, np.arange(len(r))
        shape = (3 * count + 1, len(r))
        ends = np.concatenate([i, j, i + count, j + count])
        edges = np.tile(e, 4)

        def on_grains(v: np.ndarray) -> csr_array:
            return csr_array(
                (np.concatenate([v.real, -v.real, v.imag, -v.imag]), (ends, edges)), shape=shape
            )

        cell = csr_array((r / self.span, (np.full(len(r), 3 * count), e)), shape=shape)
        twist = csr_array(
            (np.ones(2 * len(r)), (2 * count + np.r_[i, j], np.r_[e, e])), shape=shape
        )
        sideways = on_grains(1j * n)
        return on_grains(-n) + cell, sideways + twist, sideways

    def response(self, trial: Trial) -> tuple[Floats, Floats, Floats]:
        """df_n/dδr, df_t/dδq and df_t/dδr of every contact."""
        law = self.law
        on_normal = np.where(trial.bearing, -law.slope(trial.overlap), 0.0)
        sticks = trial.bearing & ~trial.sliding
        k_t = law.tangential_stiffness(trial.overlap)
        on_slip = np.where(sticks & self.rotates, k_t, 0.0)
        slides = law.friction * np.sign(trial.tangential) * np.where(trial.sliding, on_normal, 0.0)
        return on_normal, on_slip, slides

    def tangent(self, trial: Trial) -> csr_array:
        """dR/dy ``(3N + 1, 3N + 1)``."""
        on_normal, on_slip, slides = map(diags_array, self.response(trial))
        m_n, m_t, sideways = trial.m_n, trial.m_t, trial.sideways
        last = 3 * self.count
        # Turning changes the direction of a force, hence the grains' rows, not Σ f_n r.
        on_grains = diags_array(np.r_[np.ones(last), 0.0]) @ m_n
        tangent = m_n @ on_normal @ m_n.T - m_t @ on_slip @ m_t.T + m_t @ slides @ m_n.T
        tangent += sideways @ diags_array(trial.normal / trial.r) @ sideways.T
        tangent -= on_grains @ diags_array(trial.tangential / trial.r) @ sideways.T
        cell_row = m_n @ trial.normal / self.span
        cell_row[-1] -= 2 * trial.load / self.span
        where = (np.full(last + 1, last), np.arange(last + 1))
        return csr_array(tangent + coo_array((cell_row, where), tangent.shape))

    def factorise(self, trial: Trial, shift: float = PIN) -> Callable[[Floats], Floats]:
        """Sparse LU of the tangent minus ``shift`` κ: residual -> Newton step.

        Rattlers are left out: they only follow the cell.
        """
        grains = np.zeros(self.count, bool)
        grains[self.near.pairs[trial.bearing]] = True
        active = np.flatnonzero(np.r_[grains, grains, grains & self.rotates, True])
        reduced = csc_array(self.tangent(trial))[active][:, active]
        lu = splu(csc_array(reduced - shift * self.stiffness * eye_array(len(active))))

        def newton_step(residual: Floats) -> Floats:
            y = np.zeros(len(residual))
            y[active] = -lu.solve(residual[active])
            return y

        return newton_step
