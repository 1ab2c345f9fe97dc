"""Contacts that nobody lists: probabilities from gaps."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from scaling import force_equation, perturb, reconstruct
from scaling.estimators import Bounded
from scaling.estimators.told.contacts import Mixture, contacts_from_gaps
from tests.conftest import packing
from tests.scaling.packings import network_of


def drawn(rng, overlap, s, contacts=3000, apart=2000, reach=1.0):
    """Gaps of the model itself, and which are closed."""
    gaps = np.append(-rng.exponential(overlap, contacts), rng.uniform(0, 1.5 * reach, apart))
    closed = np.arange(len(gaps)) < contacts
    gaps = gaps + s * rng.standard_normal(len(gaps))
    seen = gaps < reach
    return gaps[seen], closed[seen]


@pytest.mark.parametrize("s", [0.01, 0.1, 0.2])
def test_probabilities_are_shares(s):
    """In each range of probability so many are closed, within six binomial deviations; told a
    noise three times too small (the control) they are not."""
    gaps, closed = drawn(np.random.default_rng(0), 0.02, s)

    def off(told):
        P = Mixture.of(gaps, 0.02, np.full(len(gaps), told), 1.0).closed
        worst = 0.0
        for low in np.linspace(0, 0.8, 5):
            mine = (low <= P) & (low + 0.2 >= P)
            if mine.sum() >= 20:
                variance = np.sum(P[mine] * (1 - P[mine])) + 1
                worst = max(worst, abs(np.sum(closed[mine] - P[mine])) / np.sqrt(variance))
        return worst

    assert off(s) < 6
    assert off(s / 3) > 6


def test_counts_are_those_of_the_largest_evidence():
    """c and ρ within six deviations of what was drawn, √c from counting alone."""
    gaps, closed = drawn(np.random.default_rng(1), 0.02, 0.1)
    found = Mixture.of(gaps, 0.02, np.full(len(gaps), 0.1), 1.0)
    assert found.contacts == pytest.approx(closed.sum(), abs=6 * 2 * np.sqrt(len(gaps)))
    assert found.density == pytest.approx(2000 / 1.5, rel=0.2)
    touching = np.flatnonzero(found.closed >= 0.5)
    assert gaps[touching].max() <= found.threshold + 1e-3


def bare(network, p):
    return SimpleNamespace(positions=network.positions, radii=network.radii, cell=p.cell)


def test_good_data_have_their_contacts():
    """At ξ = Δ/100 all contacts that bear more than the noise, and no other; at 30 Δ (the control)
    many others, less probable."""
    p = packing(grains=100, delta=1e-3)
    n = network_of(p)
    true = {tuple(pair) for pair in n.pairs.tolist()}
    lists = []
    for xi in (1e-5, 3e-2):
        noisy = perturb(n, xi, np.random.default_rng(0), "position")
        lists.append(contacts_from_gaps(bare(noisy, p), p.pressure / p.stiffness, xi))
    good, poor = ({tuple(pair) for pair in x.network.pairs.tolist()} for x in lists)
    assert len(true ^ good) <= 0.02 * len(true)
    assert len(true ^ poor) > 0.1 * len(true)
    right = np.array([tuple(pair) in true for pair in lists[1].network.pairs.tolist()])
    assert lists[1].closed[right].mean() > lists[1].closed[~right].mean()
    assert lists[0].closed.min() > 0.1
    assert lists[0].mixture.threshold < lists[1].mixture.threshold


def test_units_of_length_drop_out():
    p = packing(grains=48, delta=1e-3)
    noisy = perturb(network_of(p), 1e-3, np.random.default_rng(0), "position")
    here = contacts_from_gaps(bare(noisy, p), 1e-3, 1e-3)
    a = 7e-3
    big = SimpleNamespace(positions=a * noisy.positions, radii=a * noisy.radii, cell=a * p.cell)
    there = contacts_from_gaps(big, a * 1e-3, 1e-3)  # ξ is in mean diameters
    assert (there.network.pairs == here.network.pairs).all()
    assert there.closed == pytest.approx(here.closed, abs=1e-6)


def test_a_contact_that_is_surely_closed_is_one_of_the_list_and_one_that_is_not_bears_nothing():
    """P = 1 changes nothing; P → 0 takes the force away, where nothing is measured."""
    p = packing(grains=48, delta=1e-3)
    n, told = network_of(p), {"friction": p.friction, "pressure": p.pressure, "xi": np.inf}
    plain = reconstruct(n, p.stiffness, "bounded", **told).forces
    sure = reconstruct(n, p.stiffness, "bounded", closed=np.ones(n.contacts), **told).forces
    assert sure == pytest.approx(plain, abs=1e-6 * plain.max())
    P = np.ones(n.contacts)
    k = int(np.argsort(plain[: n.contacts])[n.contacts // 2])
    P[k] = 1e-6
    without = reconstruct(n, p.stiffness, "bounded", closed=P, **told).forces
    assert plain[k] > 0.1 * plain[: n.contacts].mean()
    assert without[k] < 0.2 * plain[k]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"overlap": 0.0}, "overlap = 0.0"),
        ({"least": 2.0}, "least = 2.0"),
        ({"xi": -1.0}, "xi = -1.0"),
    ],
)
def test_odd_arguments_are_refused(given, message):
    p = packing(grains=48, delta=1e-3)
    known = {"overlap": 1e-3, "xi": 1e-3} | given
    with pytest.raises(ValueError, match=message):
        contacts_from_gaps(bare(network_of(p), p), **known)


def test_odd_probabilities_are_refused():
    p = packing(grains=48, delta=1e-3)
    equation = force_equation(network_of(p)).with_law(p.stiffness)
    for P, message in (
        (np.ones(3), r"closed has shape \(3,\)"),
        (np.full(equation.network.contacts, 1.5), "contact 0 has the probability"),
    ):
        with pytest.raises(ValueError, match=message):
            Bounded(friction=0.3, pressure=1e-3, xi=1e-3, closed=P).posterior(equation)
    far = SimpleNamespace(positions=[(0.0, 0.0), (3.0, 0.0)], radii=[0.5, 0.5])
    with pytest.raises(ValueError, match="there is no contact"):
        contacts_from_gaps(far, 1e-3, 1e-3)
