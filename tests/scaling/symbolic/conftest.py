"""One small relaxed packing for the tests that compare expansions with full networks."""

from __future__ import annotations

import pytest

from scaling import ContactNetwork
from tests.conftest import packing as relaxed


@pytest.fixture(scope="session")
def packing():
    """About 40 grains at Δ = 1e-3, relaxed to balance: some 70 contacts on a torus."""
    return relaxed(40, 1e-3)


@pytest.fixture(scope="session")
def network(packing):
    return ContactNetwork.from_packing(packing)
