"""What a record holds is kept by whatever is made of it: indices, masks, springs, order, flags."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from dem import ContactLaw, Drive, History, State, step
from scaling import ContactNetwork, error_map, reconstruct, rescaled, tiled_forces

TRIANGLE = [[0, 0], [1, 0], [0.5, 0.9]]
PAIRS = [[0, 1], [0, 2], [1, 2]]


def test_contact_index_of_a_network_rescaled():
    """A network that was cut knows its contacts in the whole, also after its sizes change."""
    x = [[0, 0], [1, 0], [2, 0], [0.5, 0.9], [1.5, 0.9]]
    whole = ContactNetwork(x, [0.52] * 5, [[1, 2], [0, 1], [0, 3], [1, 3], [1, 4], [3, 4]])
    part = whole.inside([0, 1, 3], np.ones(6))
    assert rescaled(part, 1e-6).contact_index.tolist() == part.contact_index.tolist() == [1, 2, 3]


def test_masked_entries_are_no_numbers():
    """A masked coordinate is not -9999, a masked force not 1e9."""
    x = np.ma.masked_array([[0, 0], [1, 0], [0.5, -9999.0]], mask=[[0, 0], [0, 0], [0, 1]])
    with pytest.raises(ValueError, match="positions"):
        ContactNetwork(x, [0.5] * 3, PAIRS)
    network = ContactNetwork(TRIANGLE, [0.52] * 3, PAIRS)
    masked = np.ma.masked_array([1, 1, 1e9], mask=[0, 0, 1])
    with pytest.raises(ValueError, match="normal_forces"):
        reconstruct(network, None, "transverse", normal_forces=masked)


def test_springs_with_a_stale_image():
    """Positions wrapped into the cell: the pair meets through another image, with its spring."""
    x = np.mod(np.array([[7.3, 3.0], [8.28, 3.1]]), 8.0)
    history = History([[0, 1]], [[0, 0]], [0.004])
    state = State(x, [0.5, 0.5], cell=np.diag([8.0, 8.0]), history=history)
    after = step(state, ContactLaw(), 0.05).history.elongations.sum()
    assert after == pytest.approx(0.004, abs=1e-3)


def test_columns_of_forces_are_refused():
    """(c, 2) columns of f_n, f_t are no list f_n then f_t, and would be scrambled."""
    network = ContactNetwork(TRIANGLE, [0.52] * 3, PAIRS, cell=np.eye(2) * 9)
    f = np.arange(6.0)
    assert tiled_forces(network, f, 1).tolist() == f.tolist()
    with pytest.raises(ValueError, match=r"forces has shape \(3, 2\)"):
        tiled_forces(network, f.reshape(2, 3).T, 1)


def test_an_error_map_travels():
    """To worker processes and back, as networks do."""
    map_ = error_map(ContactNetwork(TRIANGLE, [0.52] * 3, PAIRS))
    assert pickle.loads(pickle.dumps(map_)).gain == pytest.approx(map_.gain, rel=1e-12)


def test_a_network_is_read_only_after_pickling():
    """Else σ, kept, and the radii, changed, disagree in silence."""
    network = pickle.loads(pickle.dumps(ContactNetwork([[0, 0], [1, 0]], [0.52, 0.5], [[0, 1]])))
    with pytest.raises(ValueError, match="read-only"):
        network.radii[:] = 0.7
    assert network.sigma[0] == network.radii.sum()


@pytest.mark.parametrize("law", [ContactLaw(), ContactLaw(dashpot=0.3)])
def test_a_state_goes_on_where_it_was_pickled(law):
    """Twelve steps, or six, a copy, and six more: with dashpots too."""

    def moved(cut: int) -> np.ndarray:
        velocities = [[0.1, 0], [-0.1, 0.05], [0, -0.1]]
        s = State([[0, 0], [0.97, 0.1], [0.4, 0.85]], [0.5] * 3, velocities=velocities)
        for steps in (cut, 12 - cut):
            if steps:
                s = pickle.loads(pickle.dumps(s)) if cut < 12 else s
                s = step(s, law, 0.1, drive=Drive(0.1), steps=steps, backend="numpy")
        return s.positions

    assert abs(moved(6) - moved(12)).max() <= 1e-12
