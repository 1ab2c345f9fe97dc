"""All sizes wrong by one factor: harmless around faces, amplified around the cell."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from scaling import ContactNetwork, force_equation
from scaling.symbolic import pseudo_inverse, triangle
from scaling.symbolic.argument.common_mode import chain_response, epsilon, face_response
from scaling.symbolic.inputs.contact_law import Delta


def response(network, packing, factor, winding):
    """δf̂ for sizes (1 + ε)σ, loads known."""
    equation = force_equation(network, winding=winding)
    G, Q = equation.G.toarray(), equation.Q.toarray()
    data = Q @ network.sigma * factor * packing.stiffness / packing.pressure
    right = np.concatenate([np.zeros(G.shape[0] - len(data)), data])
    return np.linalg.lstsq(G, right, rcond=None)[0]


def test_faces_alone_are_harmless_on_a_packing(network, packing):
    """Exactly G⁺(0; Q f̂_n) ε, whatever Δ: at most the forces themselves times ε."""
    f = packing.forces / packing.pressure
    change = response(network, packing, 1e-6, winding=False)
    assert np.linalg.norm(change) < 2e-6 * np.linalg.norm(f)


def test_winding_loops_amplify_on_a_packing(network, packing):
    """0.4-0.8 ε/Δ in units of the mean force: a thousand times the faces' response."""
    f = packing.forces / packing.pressure
    change = response(network, packing, 1e-6, winding=True)
    rms = np.sqrt(np.mean(change**2)) / np.mean(np.hypot(*f.reshape(2, -1)))
    assert 0.2 < rms / (1e-6 / packing.delta) < 1.5
    assert np.linalg.norm(change) > 50 * np.linalg.norm(
        response(network, packing, 1e-6, winding=False)
    )


def test_an_open_region_with_known_loads_is_harmless(network, packing):
    """Cut out half the cell; the cut contacts' forces are loads, all loops are faces."""
    c = network.contacts
    cell = np.asarray(packing.cell)
    fraction = (packing.positions @ np.linalg.inv(cell)) % 1
    mask = (np.abs(fraction - 0.5) < 0.42).all(axis=1)
    region = network.inside(mask, packing.forces[:c], packing.forces[c:])
    assert isinstance(region, ContactNetwork)
    assert len(region.loops) >= 2
    change = response(region, packing, 1e-6, winding=False)
    f = packing.forces.reshape(2, -1)[:, region.contact_index].ravel() / packing.pressure
    assert np.linalg.norm(change) < 2e-6 * np.linalg.norm(f)


def test_exact_response_of_the_triangle_contains_no_delta():
    f = sp.Matrix([2, 1, 3, 0, 0, 0])
    change = face_response(triangle().at(), f)
    assert not change.free_symbols
    network = triangle().at()
    known_loads = pseudo_inverse(network)[:, :9] * network.M() * f
    assert sp.simplify(change + known_loads - f) == sp.zeros(6, 1)  # G⁺G f = f


@pytest.mark.parametrize("grains", [2, 3, 6])
def test_periodic_row_amplifies_by_one_over_delta(grains):
    assert sp.simplify(chain_response(grains) - epsilon / Delta) == 0


def test_bad_input_names_the_culprit():
    with pytest.raises(ValueError, match="5 forces for 3 contacts"):
        face_response(triangle().at(), sp.ones(5, 1))
    with pytest.raises(ValueError, match="grains = 1"):
        chain_response(1)
