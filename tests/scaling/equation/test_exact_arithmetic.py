"""The whole reconstruction against 60 digits, on small packings."""

from __future__ import annotations

import numpy as np
import pytest

from dem import refine
from scaling import ContactNetwork, force_equation, perturb, reconstruct
from tests.conftest import packing
from tests.scaling.exact import exact_forces

EPS = np.finfo(float).eps


@pytest.mark.parametrize("delta", [1e-1, 1e-4, 1e-10])
@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_forces_against_exact_arithmetic(delta, friction):
    """Dense and factorised, and the forces of the simulation, to 4 ε (condition) of the largest
    force; the plain doubles of the same packing miss by ~ ε L/Δ (the control)."""
    p = packing(grains=16 if friction else 20, delta=delta, friction=friction, seed=2)
    p = p if p.positions_low is not None else refine(p)
    network, frictional = ContactNetwork.from_packing(p), friction > 0
    true = np.array([float(f) for f in exact_forces(p, network)])
    condition = force_equation(network, frictional).conditioning.condition
    allowed = 4 * EPS * condition * np.abs(true).max()
    for solver in ("dense", "factor"):
        found = reconstruct(network, p.stiffness, frictional=frictional, solver=solver)
        assert np.abs(found.forces - true).max() <= allowed
    assert np.abs(p.forces - true).max() <= allowed + 10 * p.residuals().max() * p.pressure
    if delta < 1e-3:
        plain = ContactNetwork(p.positions, p.radii, p.pairs, cell=p.cell, images=p.images)
        rough = reconstruct(plain, p.stiffness, frictional=frictional).forces
        assert np.abs(rough - true).max() > 10 * allowed


def test_noisy_forces_against_exact_arithmetic():
    """Noise makes Eq. 1 inconsistent, ξ = Δ = 1e-8: still the exact least squares solution."""
    p = packing(grains=16, delta=1e-8, seed=2)
    network = perturb(ContactNetwork.from_packing(p), 1e-8, np.random.default_rng(0))
    true = np.array([float(f) for f in exact_forces(p, network)])
    condition = force_equation(network).conditioning.condition
    found = reconstruct(network, p.stiffness).forces
    assert np.abs(found - true).max() <= 100 * EPS * condition * np.abs(true).max()
    assert np.abs(found - p.forces).max() > 1e-2 * p.pressure
