"""The collapse of all worlds: it holds on ξ/Δ*, and neither on ξ nor on the Δ of another law."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from paper_figs import fig8
from studies import packing_store
from studies.packing_store import FULL, QUICK
from studies.prefactors import world_layers, worlds
from studies.tables import read_table

SMALL = replace(QUICK, name="small", backend="auto")
FEW = [("periodic", "linear", 0.3)]
FEW += [(world, kind, 0.3) for world in ("rough walls", "weight") for kind in worlds.CONTACTS]


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Three worlds, both laws, Δ = 1e-2 and 1e-4, two packings of 40 grains each, two draws."""
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(1) as pool:
        patch.setattr(packing_store, "STORE", tmp_path_factory.mktemp("packings"))
        patch.setattr(worlds, "cases", lambda: FEW)
        patch.setattr(worlds, "DRAWS", 2)
        patch.setattr(worlds, "size_of", lambda edition: (40, 2))
        patch.setattr(world_layers, "size_of", lambda edition: (40, 2))
        return worlds.compute(SMALL, pool), world_layers.compute(SMALL, pool)


def spread(table, scale):
    """The largest over the smallest E Δ/ξ of all packings and strengths; 1 is a collapse."""
    unit = table[scale] if scale else 1.0
    over = [table[f"E_{r}"] / (table[f"ratio_{r}"] * table["delta"] / unit) for r in worlds.RANGES]
    return np.max(over) / np.min(over)


def check(table, within):
    """The controls spread over as many decades as the scale does that they leave out."""
    assert spread(table, "delta") < within
    assert spread(table, "") > 50
    assert spread(table, "wrong_delta") > 50
    assert table["refused"].sum() < 0.01 * len(table) * len(worlds.RANGES) * worlds.DRAWS
    assert table["exact"].max() < 1e-10
    assert table["residual"].max() < 1e-11


def test_all_worlds_collapse(tables):
    """C is 0.2 to 0.9 for these, and one strength is measured on two draws: within a factor 6."""
    check(tables[0], 6)


def test_what_is_measured_is_what_the_error_map_says(tables):
    """Means over 20 packings with two draws each, of E² over its expectation."""
    for name in worlds.RANGES:
        squares = worlds.over_prefactor(tables[0], name) ** 2
        assert squares.mean() == pytest.approx(1, abs=0.35)


def test_layers_have_their_own_delta(tables):
    """Each layer's C varies less than with the Δ of the whole; weights alone cost no 1/Δ."""
    layers = tables[1]
    assert np.abs(layers["borne"] - 1).max() < 1e-10
    for told in worlds.DELTAS:
        mine = layers[(layers["told_delta"] == told) & (layers["layer"] > 0)]
        inner = mine[mine["layer"] < world_layers.LAYERS - 1]
        assert (inner["C"] < 1).all()
        assert (inner["C"] > 0.1).all()
    stiff, soft = (layers["weight_only"][layers["told_delta"] == d] for d in (1e-4, 1e-2))
    assert stiff.max() < 1
    assert stiff.mean() < 3 * soft.mean()


def test_the_committed_tables_say_the_same():
    """Publication edition, every world: the same controls, and layers closer to one C."""
    table = read_table(FULL.figures / "fig8.csv")
    assert set(table["world"]) == set(worlds.WORLDS)
    check(table, 8)
    layers = read_table(FULL.figures / "fig8_layers.csv")
    assert len(fig8.plot(table, layers).axes) == 6
    for contact in worlds.CONTACTS:
        mine = layers[(layers["contact"] == contact) & (layers["told_delta"] == 1e-4)]
        own = [mine["C"][mine["layer"] == k].mean() for k in range(world_layers.LAYERS)]
        whole = [(mine["error_of_xi"] * mine["whole_delta"])[mine["layer"] == k].mean()
                 for k in range(world_layers.LAYERS)]  # fmt: skip
        assert np.ptp(own) < 0.6 * np.ptp(whole)
