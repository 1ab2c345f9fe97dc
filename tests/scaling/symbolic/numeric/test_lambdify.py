"""Symbols against floating point on the same networks, over random geometries.

Tolerances: M and Q are evaluated entry by entry, a few eps.  K comes from a pseudo-inverse,
eps times the condition number of G.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import scaling
from scaling import symbolic
from scaling.symbolic import bowtie, rhombus, ring, square, squared_gain, triangle, wheel
from scaling.symbolic.loops.named_networks import u, v
from scaling.symbolic.numeric import lambdify

EPS = np.finfo(float).eps
NETWORKS = {
    n.name: n
    for n in (
        triangle(),
        square(),
        rhombus(),
        bowtie(),
        ring(3),
        ring(5),
        ring(8),
        wheel(3),
        wheel(6),
    )
}
FREE = ("triangle", "square", "rhombus", "bowtie")
GAINS = {(name, mu): squared_gain(NETWORKS[name], mu) for name in FREE for mu in (False, True)}

tangents = st.floats(0.05, 0.95)


@st.composite
def geometries(draw):
    """A small network with free angles: the picture shrinks towards small, simple angles."""
    name = draw(st.sampled_from(FREE))
    values = {u: draw(tangents)}
    if name == "triangle":
        values[v] = draw(tangents)
    return name, values


def rows_matched(exact, numeric):
    """Rows of Q agree up to the order of the loops."""
    size = len(exact) // 2
    pairs = lambda Q: np.hstack([Q[:size], Q[size:]])  # noqa: E731
    distance = np.abs(pairs(exact)[:, None] - pairs(numeric)[None]).max(axis=2)
    return distance.min(axis=1).max() + distance.min(axis=0).max()


def compare(network, values, frictional):
    numeric = lambdify.contact_network(network, values)
    equation = scaling.force_equation(numeric, frictional=frictional)
    M, Q, G = lambdify.matrices(network, frictional, values)
    size = numeric.positions.max() / numeric.radii.min()  # normals from rounded centres
    entry = 20 * EPS * max(size, 1)
    np.testing.assert_allclose(equation.M.toarray(), M, rtol=0, atol=entry)
    assert rows_matched(Q, equation.Q.toarray()) < entry
    condition = np.linalg.cond(G)
    K = scaling.gain(numeric, frictional=frictional) / numeric.mean_diameter
    expected = lambdify.gain(network, frictional, values=values)
    assert pytest.approx(expected, rel=entry * condition) == K
    return K, entry * condition


@given(geometries(), st.booleans())
def test_random_geometries_agree(geometry, frictional):
    name, values = geometry
    K, tolerance = compare(NETWORKS[name], values, frictional)
    # a rational function of degree ~60 in u: evaluated with rational arithmetic, then rounded
    exact = GAINS[name, frictional].subs({k: sp.Rational(float(x)) for k, x in values.items()})
    assert np.sqrt(float(exact)) == pytest.approx(K, rel=4 * tolerance)


@pytest.mark.parametrize("frictional", [False, True])
@pytest.mark.parametrize("name", ["ring(3)", "ring(5)", "ring(8)", "wheel(3)", "wheel(6)"])
def test_regular_networks_agree(name, frictional):
    K, tolerance = compare(NETWORKS[name], None, frictional)
    exact = squared_gain(NETWORKS[name], frictional)
    assert np.sqrt(float(sp.N(exact, 30))) == pytest.approx(K, rel=4 * tolerance)


@given(geometries(), st.floats(1e-6, 1e-2), st.integers(0, 2**32 - 1))
def test_forces_agree(geometry, delta, seed):
    """Truth first: choose f, load the grains with -Mf, close the loops with Qf Δ, recover f."""
    name, values = geometry
    network = NETWORKS[name]
    M, _, G = lambdify.matrices(network, True, values)
    f = np.random.default_rng(seed).uniform(0.1, 1, G.shape[1])
    numeric = lambdify.contact_network(network, values)
    loads = -(M @ f).reshape(3, -1).T * delta
    loads[:, 2] *= numeric.radii
    loaded = scaling.ContactNetwork(
        None, numeric.radii, numeric.pairs, normals=numeric.normals, external=loads
    )
    equation = scaling.force_equation(loaded)
    sizes = numeric.sigma + delta * f[: numeric.contacts]
    balance = equation.rhs(1.0)[: M.shape[0]]
    right = np.concatenate([balance, equation.Q @ sizes])
    found = np.linalg.lstsq(equation.G.toarray(), right, rcond=None)[0] / delta
    rounding = 50 * EPS * np.linalg.cond(G) * (1 + numeric.sigma.max() / delta)
    np.testing.assert_allclose(found, f, atol=rounding * np.linalg.norm(f))


@pytest.mark.parametrize("noise", ["diameter", "radius", "relative", "position"])
@pytest.mark.parametrize("name", FREE)
def test_every_kind_of_noise_agrees(name, noise):
    """K of the numeric package is a length, the exact one is per mean diameter."""
    network = NETWORKS[name].at()
    numeric = lambdify.contact_network(network)
    K = scaling.gain(numeric, noise=noise) / numeric.mean_diameter
    condition = np.linalg.cond(lambdify.matrices(network)[2])
    exact = np.sqrt(float(squared_gain(network, noise=noise)))
    assert pytest.approx(exact, rel=100 * EPS * condition) == K


def test_amplification_of_a_loaded_rhombus():
    """C = K p/⟨|f|⟩ with explicit forces; no forces are needed for K itself."""
    network = NETWORKS["rhombus"]
    numeric = lambdify.contact_network(network)
    f = np.array([3, 1, 2, 1, 2, 0, 0.3, -0.1, 0.2, 0.1])
    K2 = float(GAINS["rhombus", True].subs(network.sample))
    expected = np.sqrt(K2) * numeric.mean_diameter * 2.5 / np.hypot(f[:5], f[5:]).mean()
    C = scaling.amplification(numeric, forces=f, pressure=2.5)
    assert pytest.approx(expected, rel=1000 * EPS) == C


def test_a_flipped_tangent_is_noticed():
    """Negative control: with t turned by -90° the numeric M is not the symbolic one."""
    network = rhombus()
    M, *_ = lambdify.matrices(network)
    flipped = M.copy()
    flipped[: 2 * network.grains, network.contacts :] *= -1
    numeric = scaling.force_equation(lambdify.contact_network(network)).M.toarray()
    assert np.abs(numeric - flipped).max() > 0.5


def test_bad_parameters_name_the_culprit():
    with pytest.raises(ValueError, match="triangle has no free parameter q"):
        lambdify.matrices(triangle(), values={sp.Symbol("q"): 1.0})
    with pytest.raises(ValueError, match="not all positive"):
        lambdify.contact_network(triangle(), {u: 2.0, v: 3.0})


def test_importing_scaling_loads_no_sympy():
    code = "import sys, scaling; sys.exit('sympy' in sys.modules)"
    root = Path(scaling.__file__).parents[1]
    assert subprocess.run([sys.executable, "-c", code], cwd=root, check=False).returncode == 0


def test_symbolic_loads_no_matplotlib():
    code = "import sys, scaling.symbolic; sys.exit('matplotlib' in sys.modules)"
    root = Path(scaling.__file__).parents[1]
    assert subprocess.run([sys.executable, "-c", code], cwd=root, check=False).returncode == 0


def test_only_the_bridge_lambdifies():
    folder = Path(scaling.__file__).parent / "symbolic"
    users = [path.stem for path in folder.rglob("*.py") if "lambdify(" in path.read_text()]
    assert users == ["lambdify"]


@pytest.mark.parametrize("exponent", [1, 1.5, 2])
@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 3)])
def test_functions_keep_the_shape_of_their_arguments(exponent, shape):
    """Also those that are constant: the slope of the linear law, the torque rows of a contact."""
    y = np.full(shape, 0.5)
    for function in lambdify.law(exponent):
        assert function(y).shape == shape
    np.testing.assert_allclose(lambdify.law(exponent)[1](y), exponent * 0.5 ** (exponent - 1))
    block = lambdify.contact_block()(y, y)
    assert {np.shape(entry) for row in block for entry in row} == {shape}
    orders = lambdify.expansion()(y, 0 * y, 0.1 * y)
    assert {np.shape(entry) for order in orders for entry in order} == {shape}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lambdify.law("1"), "exponent"),
        (lambda: lambdify.law(0.5)[1](np.array([1.0, 0.0])), "y = .*0.0.* not finite"),
        (lambda: lambdify.law(1)[0](np.ma.masked_array([1.0], [True])), "y is a masked array"),
        (lambda: lambdify.matrices(symbolic.square(), values={"u": 1}), "no free parameter u"),
        (lambda: symbolic.ring("5"), "n = '5'"),
        (lambda: symbolic.ring([5]), "n = .*5"),
        (lambda: symbolic.wheel(2**70), "n = 1180591620717411303424 is beyond"),
        (lambda: symbolic.rank(symbolic.square(), matrix="H"), "matrix = 'H'"),
        (lambda: symbolic.squared_gain("square"), "network = 'square'"),
        (lambda: symbolic.square_gain(frictional=1), "frictional = 1"),
    ],
)
def test_bad_arguments_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_results_are_kept_for_the_checked_arguments():
    """One network however the call is written: gains are kept by network."""
    assert symbolic.ring(5) is symbolic.ring(n=np.int64(5))
    assert symbolic.square_gain() is symbolic.square_gain(frictional=True)
