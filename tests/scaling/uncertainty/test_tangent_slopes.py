"""Contacts of elastic spheres that bear almost nothing: their compliance is out of all bounds."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import ContactNetwork, amplification, gain
from scaling.uncertainty import tangent_slopes
from tests.scaling.worlds import packing_in


def faint(p, factor):
    """Forces with one contact fainter by a factor."""
    f = p.forces.copy()
    f[[0, len(p.pairs)]] *= factor
    return f


def test_faint_contacts_leave_the_prefactor_alone(monkeypatch):
    """At any force and any floor C is the same, to the floor; with no floor it is refused."""
    p = packing_in("frictional", contact="hertz")
    n = ContactNetwork.from_packing(p)

    def C(factor):
        return amplification(n, forces=faint(p, factor), pressure=p.pressure, stiffness=p.law)

    once = C(1e-20)
    assert C(1e-40) == pytest.approx(once, rel=1e-10)
    monkeypatch.setattr(tangent_slopes, "FLOOR", 1e-3)
    assert C(1e-20) == pytest.approx(once, rel=1e-3)
    slopes = p.law.slope(p.law.overlap(faint(p, 1e-60)[: len(p.pairs)]))
    with pytest.raises(ValueError, match=r"condition|rank-deficient"):
        gain(n, stiffness=slopes)


def test_slopes_of_sound_contacts_are_those_of_the_law():
    p = packing_in("frictional", contact="hertz")
    found = tangent_slopes.tangent_slopes(p.law, p.normal_forces)
    assert np.array_equal(found, p.law.slope(p.law.overlap(p.normal_forces)))
