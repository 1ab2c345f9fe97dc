"""Eq. 1 of a law that is not linear: several starts, one answer, or none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dem import Scene, relax
from scaling import ContactNetwork, force_equation, perturb, reconstruct, relative_error
from scaling.equation import nonlinear_closure
from scaling.equation.newton_starts import newton_starts
from scaling.equation.nonlinear_closure import from_start, solve_nonlinear
from scaling.estimators import Gppsz


@pytest.fixture(scope="module")
def spheres():
    return relax(Scene(48, 1e-3, contact="hertz"), 1, progress=False)


def equation_of(p, network=None):
    network = ContactNetwork.from_packing(p) if network is None else network
    return force_equation(network).with_law(p.law)


def test_every_start_ends_in_the_forces(spheres):
    """Of exact data; the starts themselves (the control) are far from them, but the overlaps."""
    p, equation = spheres, equation_of(spheres)
    sums = equation.overlap_sums()
    starts = newton_starts(equation, p.law, sums)
    assert list(starts) == ["flat", "overlaps", "balance"]
    for name, start in starts.items():
        found, _ = from_start(equation, p.law, sums, start, "auto", None)
        assert relative_error(found.values, p.forces) < 1e-9
        far = relative_error(start, p.normal_forces, frictional=False)
        assert (far < 1e-6) if name == "overlaps" else (far > 0.05)


def test_directions_alone_have_two_starts(spheres):
    p = spheres
    n = ContactNetwork.from_packing(p)
    told = ContactNetwork(None, n.radii, n.pairs, cell=n.cell, images=n.images, normals=n.normals)
    equation = equation_of(p, told)
    assert list(newton_starts(equation, p.law, equation.overlap_sums())) == ["flat", "balance"]
    assert relative_error(reconstruct(told, p.law), p) < 1e-8


def test_contacts_that_open_do_no_harm(spheres):
    """Noise as large as Δ opens a part of the contacts: converged, stationary, or refused for
    several solutions; an answer is near C ξ/Δ, and gppsz of a linear law has as many open."""
    p, opened, answers = spheres, 0, 0
    for seed in range(4):
        noisy = perturb(ContactNetwork.from_packing(p), 1e-3, np.random.default_rng(seed))
        equation = equation_of(p, noisy)
        try:
            found = Gppsz().solve(equation)
        except RuntimeError:
            with pytest.raises(RuntimeError, match="several solutions"):
                solve_nonlinear(equation, p.law)
            continue
        answers += 1
        opened += int((found.normal < 0).sum())
        assert relative_error(found, p) < 5
        gradient = stationary(equation, found.forces)
        assert gradient < 1e-6
    assert answers == 0 or opened > 0


def stationary(equation, f):
    """|∇| of the least squares in δ and f_t, over the size of its terms."""
    law, c = equation.law, equation.network.contacts
    δ = law.overlap(f[:c])
    κ = law.slope(δ).mean()
    left, closing = (
        equation.M @ f - equation.balance_rhs(),
        κ * (equation.Q @ δ - equation.overlap_sums()),
    )
    pulled, closed = equation.M.T @ left, κ * (equation.Q.T @ closing)
    gradient = np.concatenate([law.slope(δ) * pulled[:c] + closed, κ * pulled[c:]])
    return np.linalg.norm(gradient) / np.linalg.norm(np.concatenate([κ * pulled, closed]))


def test_starts_that_end_apart_are_refused(spheres, monkeypatch):
    """By 1e-4 they are, by 1e-9 (the control) they are not."""
    equation, real = equation_of(spheres), nonlinear_closure.from_start
    ends = iter(range(100))

    def elsewhere(size):
        def solve(*arguments):
            found, residual = real(*arguments)
            factor = 1 + size * (next(ends) % 2)
            return replace(found, values=factor * found.values), residual

        return solve

    monkeypatch.setattr(nonlinear_closure, "from_start", elsewhere(1e-4))
    with pytest.raises(RuntimeError, match=r"several solutions: from the starts 'flat' and"):
        solve_nonlinear(equation, spheres.law)
    monkeypatch.setattr(nonlinear_closure, "from_start", elsewhere(1e-9))
    solve_nonlinear(equation, spheres.law)


def test_one_start_that_ends_is_not_enough(spheres, monkeypatch):
    """Where the others fail, the answer is refused with their reason."""
    equation, real = equation_of(spheres), nonlinear_closure.from_start
    calls = iter(range(100))

    def failing(*arguments):
        if next(calls):
            raise RuntimeError("after 100 steps")
        return real(*arguments)

    monkeypatch.setattr(nonlinear_closure, "from_start", failing)
    with pytest.raises(RuntimeError, match="after 100 steps"):
        solve_nonlinear(equation, spheres.law)
