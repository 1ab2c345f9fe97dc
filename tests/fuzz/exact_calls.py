"""The tables of `scaling.symbolic` and `doubledouble`, as far as their calls are quick."""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy as sp

import packing.doubledouble as dd
from scaling import symbolic
from scaling.symbolic.numeric import lambdify, nonlinear_law
from tests.fuzz.calls import Call

Rng = np.random.Generator


def _small(rng: Rng) -> Any:
    made = (symbolic.triangle, symbolic.square, symbolic.rhombus)
    return made[rng.integers(len(made))]()


def _law(exponent: Any, y: Any) -> Any:
    value, slope = lambdify.law(exponent)
    return value(y), slope(y)


def _pair(rng: Rng) -> dict[str, Any]:
    return {"a": rng.standard_normal(4), "b": rng.standard_normal(4)}


def _arithmetic(high: Any, low: Any, operand: Any) -> Any:
    x = dd.DoubleDouble.of(high, low)
    return x + operand, operand - x, x * operand, x / (dd.DoubleDouble.of(1.0) + x * x)


def _newton(rng: Rng) -> dict[str, Any]:
    M, Q, _ = lambdify.matrices(symbolic.square(), frictional=False)
    f = np.ones(4)
    return {"M": M, "Q": Q, "forces": f, "exponent": 1.5}


EXACT: tuple[Call, ...] = (
    Call("symbolic.ring", symbolic.ring, lambda g: {"n": 4}, 0.3),
    Call("symbolic.wheel", symbolic.wheel, lambda g: {"n": 4}, 0.3),
    Call("symbolic.bowtie", symbolic.bowtie, lambda g: {"bend": sp.S.Zero}, 0.3),
    Call("symbolic.rank", symbolic.rank,
         lambda g: {"network": _small(g), "frictional": True, "matrix": "G"}, 0.3),
    Call("symbolic.null_space", symbolic.null_space,
         lambda g: {"network": _small(g), "frictional": True, "matrix": "M"}, 0.2),
    Call("symbolic.loop_gaps", symbolic.loop_gaps, lambda g: {"network": _small(g)}, 0.2),
    Call("symbolic.pseudo_inverse", symbolic.pseudo_inverse,
         lambda g: {"network": symbolic.square(), "frictional": True}, 0.05, seconds=30.0),
    Call("symbolic.squared_gain", symbolic.squared_gain,
         lambda g: {"network": symbolic.square(), "frictional": True, "noise": "diameter"},
         0.05, seconds=30.0),
    Call("symbolic.ring_squared_gain", symbolic.ring_squared_gain,
         lambda g: {"frictional": True, "exponent": sp.S.One}, 0.05, seconds=30.0),
    Call("symbolic.wheel_squared_gain", symbolic.wheel_squared_gain,
         lambda g: {"size": 4, "frictional": True, "digits": 20}, 0.05, seconds=30.0),
    Call("symbolic.table", symbolic.table, lambda g: {"largest": 3}, 0.02, seconds=60.0),
    Call("symbolic.triangle_gain", symbolic.triangle_gain, lambda g: {"frictional": True}, 0.02,
         seconds=60.0),
    Call("symbolic.square_gain", symbolic.square_gain, lambda g: {"frictional": True}, 0.02,
         seconds=60.0),
    Call("bridge.law", _law, lambda g: {"exponent": 1.5, "y": np.array([0.5, 1.0, 2.0])}),
    Call("bridge.contact_network", lambdify.contact_network,
         lambda g: {"network": _small(g), "values": None}, 0.3),
    Call("bridge.matrices", lambdify.matrices,
         lambda g: {"network": _small(g), "frictional": True, "values": None}, 0.3),
    Call("bridge.gain", lambdify.gain,
         lambda g: {"network": _small(g), "frictional": True, "noise": "diameter"}, 0.3),
    Call("newton.response", nonlinear_law.response, _newton, 0.5),
    Call("two_sum", dd.two_sum, _pair, 0.5),
    Call("two_prod", dd.two_prod, _pair, 0.5),
    Call("DoubleDouble", _arithmetic,
         lambda g: {"high": g.standard_normal(3), "low": 1e-17 * g.standard_normal(3),
                    "operand": g.standard_normal(3)}),
    Call("DoubleDouble.sqrt", lambda high: dd.DoubleDouble.of(high).sqrt(),
         lambda g: {"high": g.random(3) + 0.1}, 0.3),
    Call("hypot", lambda x, y: dd.hypot(x, y),
         lambda g: {"x": dd.DoubleDouble.of(g.random(3)), "y": dd.DoubleDouble.of(g.random(3))},
         0.5),
    Call("segment_sums", dd.segment_sums,
         lambda g: {"terms": dd.DoubleDouble.of(g.random(5)), "starts": np.array([0, 2, 5])}, 0.5),
)  # fmt: skip
