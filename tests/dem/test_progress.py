"""The bar over the speed that is still to lose."""

from __future__ import annotations

import pytest

from dem.progress import RestBar


@pytest.mark.parametrize(
    ("speed", "decades"), [(float("inf"), 0.0), (10.0, 0.0), (1e-2, 2.0), (0.0, 5.0)]
)
def test_any_speed_has_its_place_on_the_bar(capsys, speed, decades):
    """None lost yet when the speed is not known, or above that of the start; all when at rest."""
    with RestBar(1e-3, 1e-5, 100, True) as bar:
        bar.show(200, speed)
        assert bar._bar.n == pytest.approx(decades)
