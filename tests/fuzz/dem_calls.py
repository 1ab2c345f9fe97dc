"""The tables of `dem` and `packing`."""

from __future__ import annotations

import copy
from dataclasses import fields
from typing import Any

import numpy as np

import dem
from packing.arguments import arrays, numbers
from tests.fuzz.calls import Arguments, Call
from tests.fuzz.samples import packing

Rng = np.random.Generator
QUICK = dem.Settings(backend="numpy", longest=200.0)


def _state(rng: Rng) -> Arguments:
    return {
        "positions": np.array([[0.0, 0.0], [0.97, 0.1], [0.4, 0.85]]), "radii": np.full(3, 0.5),
        "velocities": 0.1 * rng.standard_normal((3, 2)), "spins": np.zeros(3),
        "cell": np.diag([8.0, 8.0]), "strain_rate": 0.0, "history": dem.History(),
    }  # fmt: skip


def _step(rng: Rng) -> Arguments:
    return {
        "state": dem.State(**_state(rng)), "law": dem.ContactLaw(), "dt": 0.1,
        "drive": dem.Drive(0.1), "steps": 2, "skin": 0.2, "backend": "numpy",
        "precision": "float64",
    }  # fmt: skip


def _stepped(state: Any, **more: Any) -> Any:
    return dem.step(copy.deepcopy(state), **more)


def _record(rng: Rng) -> Arguments:
    p = packing(float(rng.choice([0.3, 0.0])))
    return {f.name: getattr(p, f.name) for f in fields(p)}


def _packing(**given: Any) -> Any:
    p = dem.Packing(**given)
    return p.forces, p.overlaps, p.residuals(), p.delta, p.coordination


def _scene(rng: Rng) -> Arguments:
    return {
        "grains": 12, "delta": 1e-2, "friction": 0.3, "polydispersity": 0.3,
        "stiffness_ratio": 0.5, "aspect": 1.0, "contact": "linear", "boundary": "periodic",
    }  # fmt: skip


def _settings(rng: Rng) -> Arguments:
    return {
        "time_step": 0.8, "drag": 1.0, "dashpot": 0.0, "velocity_tolerance": 1e-5,
        "residual_tolerance": 1e-9, "skin": 0.2, "polish": True, "longest": 3000.0,
        "backend": "numpy", "precision": "float64",
    }  # fmt: skip


DEM: tuple[Call, ...] = (
    Call("Scene", dem.Scene, _scene, 2),
    Call("Settings", dem.Settings, _settings, 2),
    Call("ContactLaw", dem.ContactLaw, lambda g: {
        "stiffness": 1.0, "stiffness_ratio": 0.5, "friction": 0.3, "dashpot": 0.0}),
    Call("Drive", dem.Drive, lambda g: {"drag": 0.1, "pressure": 1e-3}, 0.5),
    Call("History", dem.History, lambda g: {
        "pairs": np.array([[0, 1], [1, 2]]), "images": np.zeros((2, 2), dtype=int),
        "elongations": np.array([0.01, -0.01])}),
    Call("State", dem.State, _state, 3),
    Call("step", _stepped, _step, 2, allowed=(FloatingPointError,)),
    Call("Packing", _packing, _record, 4),
    Call("Packing.save", lambda path: packing().save(path),
         lambda g: {"path": "/dev/null/x"}, 0.2, allowed=(OSError,)),
    Call("Packing.load", dem.Packing.load, lambda g: {"path": "no such file.npz"},
         0.3, allowed=(OSError,)),
    Call("packing_key", dem.packing_key, lambda g: {
        "scene": dem.Scene(12, 1e-2), "seed": 1, "settings": QUICK}),
    Call("relax", dem.relax, lambda g: {
        "scene": dem.Scene(12, 1e-2), "seed": int(g.integers(9)), "settings": QUICK,
        "progress": False}, 0.05, seconds=60.0),
    Call("relax_ensemble", dem.relax_ensemble, lambda g: {
        "scenes": [dem.Scene(12, 1e-1)], "seeds": [1], "executor": None, "store": None,
        "settings": QUICK, "progress": False}, 0.05, seconds=60.0),
    Call("ramp", dem.ramp, lambda g: {
        "packing": packing(), "deltas": [2e-2], "stiffness_ratio": None, "settings": QUICK,
        "progress": False}, 0.05, seconds=60.0, allowed=(dem.PolishFailed,)),
    Call("stiffen", dem.stiffen, lambda g: {
        "packing": packing(), "delta": 5e-3, "stiffness_ratio": None}, 0.1, seconds=60.0,
         allowed=(dem.PolishFailed,)),
    Call("refine", dem.refine, lambda g: {"packing": packing(), "stiffness_ratio": None}, 0.1,
         seconds=60.0, allowed=(dem.PolishFailed,)),
    Call("real_array", lambda values, shape: arrays.real_array("values", values, shape),
         lambda g: {"values": g.random((3, 2)), "shape": (3, 2)}, 0.5, steady=("shape",)),
    Call("whole_array", lambda values: arrays.whole_array("values", values, (None, 2)),
         lambda g: {"values": g.integers(9, size=(3, 2))}, 0.5),
    Call("truth_array", lambda values: arrays.truth_array("values", values, (3,)),
         lambda g: {"values": g.random(3) > 0.5}, 0.3),
    Call("whole_number", lambda value: numbers.whole_number("value", value),
         lambda g: {"value": 3}, 0.3),
    Call("positive_number", lambda value: numbers.positive_number("value", value),
         lambda g: {"value": 0.3}, 0.3),
    Call("finite_number", lambda value: numbers.finite_number("value", value),
         lambda g: {"value": 0.3}, 0.3),
    Call("flag", lambda value: numbers.flag("value", value), lambda g: {"value": True}, 0.3),
    Call("file_path", lambda value: numbers.file_path("value", value), lambda g: {"value": "a"},
         0.3),
)  # fmt: skip
