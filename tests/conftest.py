"""Profiles of hypothesis, cached packings, and the backends at hand."""

from __future__ import annotations

import os
from functools import cache
from importlib.util import find_spec

import pytest
from hypothesis import HealthCheck, settings

from dem import Packing, Scene, Settings, relax

_slow = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile(
    "ci", max_examples=25, deadline=None, derandomize=True, suppress_health_check=_slow
)
# FUZZ_EXAMPLES: 1000 take ten minutes of one core; the packings are 1600 in all.
settings.register_profile(
    "fuzz",
    max_examples=int(os.environ.get("FUZZ_EXAMPLES", "1000")),
    deadline=None,
    suppress_health_check=_slow,
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


@pytest.fixture(params=["numpy", "numba"])
def backend(request: pytest.FixtureRequest) -> str:
    """Each kernel in turn; Numba's only where it is installed."""
    if request.param == "numba" and find_spec("numba") is None:
        pytest.skip("Numba is not installed: its kernel is not tested")
    return str(request.param)


@cache
def packing(
    grains: int = 48,
    delta: float = 1e-3,
    friction: float = 0.3,
    polydispersity: float = 0.3,
    seed: int = 1,
    **settings: object,
) -> Packing:
    """A relaxed packing, made once per test process."""
    scene = Scene(grains, delta, friction=friction, polydispersity=polydispersity)
    return relax(scene, seed, settings=Settings(**settings), progress=False)  # type: ignore[arg-type]
