"""Side walls bear a part of the weight: exactly, and as Janssen has it."""

from __future__ import annotations

import numpy as np
import pytest

from dem import relax
from studies.packings import silo


def test_what_side_walls_bear_does_not_reach_the_floor():
    """σ_yy is load and weight above, less the friction of the side walls, to round-off; without
    the friction it is not. Janssen's law has one length for all layers."""
    rows = silo.column(relax(silo.scene(150), 3, progress=False))
    assert rows["stress"] == pytest.approx(rows["exact"], rel=1e-9)
    lost = 1 - rows["stress"] / rows["without"]
    assert lost[:2].max() > 0.05
    assert np.abs(rows["janssen"] / rows["stress"] - 1).max() < 0.5
