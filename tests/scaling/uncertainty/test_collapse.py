"""collapse: the table behind the Comment's Fig. 1, on constructed packings."""

import subprocess
import sys

import numpy as np
import pytest

from scaling import collapse
from tests.scaling.networks import loaded, periodic

DELTAS = (1e-2, 1e-4, 1e-6)
RATIOS = (1e-3, 1e-1, 10.0)


@pytest.fixture(scope="module")
def packings():
    return [loaded(periodic(64, seed=k, delta=d), seed=k).packing for k, d in enumerate(DELTAS)]


@pytest.fixture(scope="module")
def table(packings):
    return collapse(packings, RATIOS, np.random.default_rng(0), draws=40)


def rms(table, field, **where):
    for name, value in where.items():
        table = table[table[name] == value]
    return np.sqrt(np.mean(table[field] ** 2))


def test_table(table, packings):
    assert set(table["packing"]) == {0, 1, 2}
    np.testing.assert_allclose(table["xi"], table["ratio"] * table["delta"], rtol=1e-15)
    assert set(table["draw"]) == set(range(40))
    for k, packing in enumerate(packings):
        assert set(table["delta"][table["packing"] == k]) == {packing.delta}


def test_strengths_above_the_limit_are_left_out(table):
    """10 Δ = 0.1 ⟨σ⟩ at Δ = 1e-2: empty; everything else is there."""
    assert len(table) == 40 * (3 * 3 - 1)
    assert table["xi"].max() <= 0.05


@pytest.mark.parametrize("ratio", RATIOS)
def test_sampled_errors_follow_the_exact_line(table, ratio):
    """E = C ξ/Δ; 40 draws of ~64 sizes leave ~2-3 %, five times that is allowed."""
    for k in range(3):
        part = table[(table["packing"] == k) & (table["ratio"] == ratio)]
        if len(part):
            np.testing.assert_allclose(rms(part, "error"), part["C"][0] * ratio, rtol=0.13)


def test_data_collapse_on_the_ratio_and_not_on_the_noise(table):
    """At equal ξ/Δ errors of Δ = 1e-2 ... 1e-6 agree to a factor 2; at equal ξ they differ by
    the ratio of the Δ."""
    same_ratio = [rms(table, "error", packing=k, ratio=1e-1) for k in range(3)]
    assert max(same_ratio) / min(same_ratio) < 2
    # ξ = 1e-5: Δ = 1e-2 and 1e-6 at ξ/Δ = 1e-3 and 10.
    same_noise = [
        rms(table, "error", packing=0, ratio=1e-3),
        rms(table, "error", packing=2, ratio=10.0),
    ]
    assert 5e3 < same_noise[1] / same_noise[0] < 2e4


def test_normal_forces_alone(table):
    """Same order as the whole; not the same number."""
    quotient = table["error_normal"] / table["error"]
    assert 0.5 < np.median(quotient) < 3
    assert np.ptp(quotient) > 0


def test_children_are_independent_of_how_many_there_are(packings, table):
    """More packings, strengths or draws leave the others bit for bit as they are."""
    few = collapse(packings[:2], RATIOS[:2], np.random.default_rng(0), draws=3)
    chosen = table[
        (table["packing"] < 2) & np.isin(table["ratio"], RATIOS[:2]) & (table["draw"] < 3)
    ]
    np.testing.assert_array_equal(few, chosen)
    other = collapse(packings[:2], RATIOS[:2], np.random.default_rng(1), draws=3)
    assert (other["error"] != few["error"]).all()


@pytest.mark.parametrize(
    ("method", "noise"), [("direct", "radius"), ("gppsz", "position"), ("transverse", "relative")]
)
def test_other_methods_and_noises(packings, method, noise):
    """Against their own C; position noise to first order in ξ/Δ, here 1e-3."""
    table = collapse(
        packings[:2], [1e-3], np.random.default_rng(0), draws=30, method=method, noise=noise
    )
    for k in range(2):
        part = table[table["packing"] == k]
        # Rounding ε L/Δ is all that is left where the method does not feel the noise.
        np.testing.assert_allclose(rms(part, "error"), part["C"][0] * 1e-3, rtol=0.15, atol=1e-9)


def test_frictionless_packings():
    packing = loaded(periodic(64), frictional=False).packing
    table = collapse([packing], [0.01, 1.0], np.random.default_rng(0), draws=20)
    np.testing.assert_array_equal(table["error"], table["error_normal"])
    np.testing.assert_allclose(rms(table, "error", ratio=1.0), table["C"][0], rtol=0.15)


def test_draws_with_a_negative_radius_are_left_out(packings):
    """ξ = 0.5 ⟨σ⟩ sampled without a limit: a radius turns negative in almost every draw."""
    table = collapse(packings[:1], [50.0], np.random.default_rng(0), draws=5, xi_max=np.inf)
    assert len(table) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"xis": [0.0]}, "strengths must be positive"),
        ({"xis": [np.nan]}, r"xis\[0\] \(strength 0\) is nan"),
        ({"draws": 0}, "draws = 0"),
        ({"noise": "size"}, "noise 'size' is unknown"),
        ({"method": "magic"}, "method 'magic' is unknown"),
    ],
)
def test_bad_arguments(packings, arguments, message):
    given = {"xis": [1.0], "draws": 1} | arguments
    with pytest.raises(ValueError, match=message):
        collapse(packings, given.pop("xis"), np.random.default_rng(0), **given)


def test_import_stays_light():
    """`import scaling` loads no sympy, no matplotlib and no simulation."""
    heavy = "{'sympy', 'matplotlib', 'dem'} & set(sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", f"import sys, scaling; print({heavy})"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == "set()"


@pytest.mark.parametrize("xi_max", [np.nan, 0.0, -1.0])
def test_a_largest_strength_that_is_none_is_refused(xi_max):
    with pytest.raises(ValueError, match=f"xi_max = {xi_max}: the largest strength"):
        collapse([], [1.0], np.random.default_rng(0), xi_max=xi_max)
