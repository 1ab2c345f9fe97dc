"""Arguments of the wrong kind: a ValueError that names the argument, whatever was given."""

from __future__ import annotations

import numpy as np
import pytest

from packing.arguments.coordinate_rounding import resolution, rounding_noise
from scaling import flat_guess, reconstruct
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.draws.posterior_mean import widened
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.bounded.prior import Prior
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.credible_intervals import coverage, enclosing, posterior_intervals
from tests.conftest import packing
from tests.scaling.packings import network_of

NEITHER = [
    "1", 1j, np.ma.array([1.0, 2.0], mask=[0, 1]), object(), {}, np.array("x"),
    np.datetime64("2020"), [[1], [1, 2]], np.array(None), b"x",
]  # fmt: skip
"""Neither numbers nor arrays of numbers."""
NO_NUMBER = [*NEITHER, np.nan, [], np.ma.masked, (1, 2), np.ones(3)]
NO_DATUM = [*NEITHER, np.nan, [], np.ma.masked, (1, 2, 3), (1, -2), (1, "x"), np.ones(3)]
"""Of what may have an error bar: (1, 2) is 1 ± 2."""
DATA = ("pressure", "friction")
ARRAYS = ("values", "sample", "mask", "low", "high", "true", "normal_forces", "tangential_forces")


def calls():
    p = packing(grains=20, delta=1e-2)
    n, rng = network_of(p), np.random.default_rng(0)
    problem = posterior(n, 1.0, 0.3, noise_model(n, xi=1e-3), pressure=p.pressure)
    common = {"network": n, "stiffness": 1.0}
    ends = {"low": np.zeros(3), "high": np.ones(3), "true": np.ones(3), "slack": 0.0}
    return {
        "bounded": (reconstruct, common | {
            "method": "bounded", "frictional": True, "solver": "auto", "tol": None, "xi": 1e-3,
            "noise": "diameter", "data": "all", "friction": 0.3, "pressure": p.pressure,
            "progress": None, "normal_forces": None,
        }),
        "transverse": (reconstruct, common | {
            "method": "transverse", "normal_forces": p.normal_forces, "friction": None}),
        "lsmr": (reconstruct, common | {"method": "gppsz", "solver": "lsmr", "tol": 1e-9}),
        "posterior": (posterior, common | {
            "friction": 0.3, "noise": None, "pressure": p.pressure, "data": "all",
            "frictional": True, "prior": None, "gaps": False,
        }),
        "prior": (Prior, {"mean": 1.0, "normal": 1.0, "tangential": 0.5}),
        "flat_guess": (flat_guess, {"network": n, "pressure": p.pressure}),
        "posterior_draws": (posterior_draws, {"posterior": problem, "rng": rng, "draws": 1}),
        "truncated_draws": (truncated_draws, {
            "posterior": problem, "rng": rng, "draws": 1, "burn_in": 0}),
        "posterior_intervals": (posterior_intervals, {
            "posterior": problem, "rng": rng, "draws": 20, "level": 0.9, "method": "projected",
            "spread": 2.0,
        }),
        "widened": (widened, {"posterior": problem, "spread": 2.0}),
        "coverage": (coverage, ends),
        "enclosing": (enclosing, {"sample": np.ones((20, 3)), "level": 0.5}),
        "inside": (n.inside, {
            "mask": np.arange(10), "normal_forces": p.normal_forces,
            "tangential_forces": p.tangential_forces,
        }),
        "without_rattlers": (n.without_rattlers, {"frictional": True}),
        "resolution": (resolution, {"values": np.ones(3)}),
        "rounding_noise": (rounding_noise, {"values": np.ones(3), "kind": "float64"}),
    }  # fmt: skip


NAMES = (
    "bounded", "transverse", "lsmr", "posterior", "prior", "flat_guess", "posterior_draws",
    "truncated_draws", "posterior_intervals", "widened", "coverage", "enclosing", "inside",
    "without_rattlers", "resolution", "rounding_noise",
)  # fmt: skip


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", NAMES)
def test_odd_arguments_are_named(name):
    """Each argument in turn is replaced; the control: all as they should be."""
    pytest.importorskip("clarabel")
    call, right = calls()[name]
    call(**right)
    for argument in right:
        odds = NEITHER if argument in ARRAYS else NO_NUMBER
        if name in ("bounded", "posterior") and argument in DATA:
            odds = NO_DATUM
        for odd in odds:
            with pytest.raises(ValueError, match=argument):
                call(**right | {argument: odd})


@pytest.mark.parametrize(
    ("argument", "value"),
    [("stiffness", 1e200), ("stiffness", 1e-200), ("friction", 1e141), ("pressure", -1.0),
     ("pressure", 0.0), ("xi", 0.0), ("xi", -np.inf), ("stiffness", True), ("friction", True),
     ("frictional", 1), ("method", None), ("data", None), ("noise", None), ("solver", None)],
)  # fmt: skip
def test_numbers_out_of_range_and_flags_that_are_none(argument, value):
    p = packing(grains=20, delta=1e-2)
    right = {"network": network_of(p), "stiffness": 1.0, "method": "bounded", "xi": 1e-3,
             "friction": 0.3, "pressure": p.pressure}  # fmt: skip
    with pytest.raises(ValueError, match=argument):
        reconstruct(**right | {argument: value})
