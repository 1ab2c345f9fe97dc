"""Where the prefactors come from: identities, bounds, and what they say on packings."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from scaling import cramer_rao, error_map, force_equation
from scaling.symbolic.loops import fourier
from scaling.uncertainty.prefactor import loop_shares, self_stress_gain
from tests.conftest import packing
from tests.scaling.networks import lattice, periodic, ring
from tests.scaling.packings import network_of

EPS = np.finfo(float).eps


@pytest.mark.parametrize("delta", [1e-1, 1e-2, 1e-5])
@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_the_shares_add_up_within_their_bounds(delta, friction):
    """K² by the error map; h <= tr T <= rank Q, both strict; K_d² above its floor, itself above
    half the hyperstaticity."""
    p = packing(delta=delta, friction=friction)
    n, frictional = network_of(p), friction > 0
    shares = loop_shares(n, frictional)
    K = error_map(n, frictional=frictional).gain / n.mean_diameter
    assert shares.square == pytest.approx(K**2, rel=1e6 * EPS)
    assert shares.hyperstaticity < shares.leverage < shares.loops
    assert shares.independent > shares.floor > shares.hyperstaticity / 2


@pytest.mark.parametrize("sides", [3, 4, 5, 8])
def test_rings_by_hand(sides):
    """A regular polygon turns by 2π/m at each corner; K² as the Fourier sum has it."""
    shares = loop_shares(ring(sides))
    assert shares.turning == pytest.approx(np.cos(2 * np.pi / sides), abs=1e3 * EPS)
    exact = fourier.ring_squared_gain().subs({fourier.theta: 2 * sp.pi / fourier.n})
    assert shares.square == pytest.approx(float(exact.subs(fourier.n, sides)), rel=1e6 * EPS)
    # One loop in m contacts: half the loops per contact would be 1/2m, and K² is not that.
    assert abs(shares.square * 2 * sides - 1) > 0.1


def test_sharing_grains_changes_sign_at_four():
    """Faces of few sides turn by more than 90°, K_s² < 0; of many by less, K_s² > 0."""
    soft, stiff = (loop_shares(network_of(packing(delta=d))) for d in (1e-1, 1e-5))
    assert soft.turning < 0
    assert soft.shared < 0
    assert stiff.turning > 0
    assert stiff.shared > 0


def test_errors_that_contacts_do_not_share():
    """Noise of variance ½ on each σ_e by itself, by the pseudo-inverse of G: K_d² and no more."""
    n = network_of(packing(delta=1e-1))
    equation, c = force_equation(n), n.contacts
    data = np.vstack([np.zeros((equation.M.shape[0], c)), equation.Q.toarray()]) * np.sqrt(0.5)
    K = np.linalg.norm(np.linalg.pinv(equation.G.toarray()) @ data) / np.sqrt(2 * c)
    shares = loop_shares(n)
    assert shares.independent == pytest.approx(K**2, rel=1e6 * EPS)
    assert abs(shares.shared) > 0.1 * shares.independent


@pytest.mark.parametrize("friction", [0.3, 1.0])
def test_bound_from_states_of_self_stress(friction):
    """Directions exact in M: the formula is the bound to rounding; with their turning, to O(Δ)."""
    p = packing(delta=1e-4, friction=friction, seed=2)
    n = network_of(p)
    K = self_stress_gain(n)
    assert pytest.approx(cramer_rao(n, "position").gain, rel=1e-7) == K
    true = cramer_rao(n, "position", forces=p.forces, stiffness=p.stiffness).gain
    assert pytest.approx(true, rel=100 * p.delta) == K
    assert abs(K / true - 1) > EPS**0.5  # they are not the same thing


def test_above_four_distances_depend_on_each_other():
    with pytest.raises(
        ValueError, match=r"150 distances of 60 grains .* the formula is for Z < 4"
    ):
        self_stress_gain(periodic(60, coordination=5.0))


def test_lattices_are_refused():
    with pytest.raises(ValueError, match="rank-deficient"):
        loop_shares(lattice("square", 4))
