"""The table of `scaling`: its public names, and the helpers that users call."""

from __future__ import annotations

import copy
from types import SimpleNamespace
from typing import Any

import numpy as np

import scaling
from scaling.estimators import Bounded
from scaling.estimators.bounded import posterior, prior
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.geometry.high_precision import LowParts
from scaling.noise import conventions
from scaling.noise.noise_model import noise_model
from scaling.uncertainty import collapse, credible_intervals, prefactor
from studies import contact_lists
from tests.fuzz.calls import Arguments, Call
from tests.fuzz.samples import cellular, problem, sample

Rng = np.random.Generator
NOISES = ("diameter", "radius", "relative", "position")
LINEAR = ("gppsz", "direct", "transverse", "balanced", "optimal")


def _pick(rng: Rng, *options: Any) -> Any:
    return options[rng.integers(len(options))]


def _seeded(rng: Rng) -> Rng:
    return np.random.default_rng(int(rng.integers(2**32)))


def _arrays(rng: Rng) -> Arguments:
    n = sample(rng).network
    given: Arguments = {"positions": n.positions, "radii": n.radii, "pairs": n.pairs}
    if n.cell is not None:
        given |= {"cell": n.cell, "images": n.images}
    if n.positions is None or rng.random() < 0.3:
        given["normals"] = n.normals
    if rng.random() < 0.3:
        given["external"] = n.external
    if n.positions is not None and rng.random() < 0.2:
        given["low"] = LowParts(1e-17 * n.positions, 1e-17 * n.radii)
    return given


def _network(positions: Any, radii: Any, pairs: Any, **more: Any) -> Any:
    """A network and what is computed from it."""
    n = scaling.ContactNetwork(positions, radii, pairs, **more)
    loops = len(n.loops), len(n.windings), n.components, n.coordination
    lengths = (n.distances, n.overlaps) if n.positions is not None else ()
    return n, n.normals, n.tangents, n.sigma, n.degrees, n.active, lengths, loops


def _reconstruct(rng: Rng) -> Arguments:
    s = sample(rng)
    method = _pick(rng, "gppsz", "direct", "transverse", "balanced", "optimal", "bounded")
    given: Arguments = {
        "network": s.network, "stiffness": 1.0, "method": method, "frictional": s.frictional,
    }  # fmt: skip
    if method == "transverse":
        given["normal_forces"] = s.forces[: s.network.contacts]
    if method in ("optimal", "bounded"):
        given["xi"] = 1e-3
        given["noise"] = _pick(rng, "diameter", "relative")
        given["data"] = _pick(rng, "all", "sizes")
    if method == "bounded":
        given |= {"friction": 0.3 if s.frictional else None, "pressure": s.pressure}
    if method == "gppsz" and rng.random() < 0.3:
        given["solver"] = _pick(rng, "dense", "factor", "lsmr")
        if given["solver"] == "lsmr":
            given["tol"] = 1e-10
    return given


def _two_materials(rng: Rng) -> Arguments:
    s = sample(rng)
    return {
        "network": s.network, "stiffness": rng.uniform(1.0, 3.0, s.network.contacts),
        "method": _pick(rng, "gppsz", "direct", "balanced"), "frictional": s.frictional,
    }  # fmt: skip


def _intervals(network: Any, stiffness: Any, rng: Any, **known: Any) -> Any:
    equation = scaling.force_equation(network).with_law(stiffness)
    return scaling.credible_intervals(Bounded(**known), equation, rng, draws=4, level=0.5)


def _told(rng: Rng) -> Arguments:
    s = cellular(rng)
    return {
        "network": s.network, "stiffness": 1.0, "rng": _seeded(rng), "friction": 0.3, "xi": 1e-2,
        "pressure": s.pressure, "data": _pick(rng, "all", "sizes"),
    }  # fmt: skip


def _map(rng: Rng) -> Arguments:
    s = sample(rng)
    method = _pick(rng, *LINEAR)
    noise_ = _pick(rng, *NOISES) if s.network.positions is not None else "diameter"
    given: Arguments = {
        "network": s.network, "method": method, "noise": noise_, "frictional": s.frictional,
    }  # fmt: skip
    if noise_ == "position":
        given["forces"] = s.forces
        given["stiffness"] = 1.0
    return given


def _covariance(rng: Rng) -> Arguments:
    s = sample(rng)
    N = s.network.grains
    L = 1e-3 * rng.standard_normal((N, N))
    covariance = _pick(rng, L @ L.T, np.full(N, 1e-6))
    return {
        "network": s.network, "covariance": covariance, "data": "sizes",
        "frictional": s.frictional,
    }  # fmt: skip


def _made_map(draw: Rng, **more: Any) -> Arguments:
    s = cellular(draw)
    return {"map": scaling.error_map(s.network, frictional=s.frictional), **more}


def _inferred(rng: Rng) -> Arguments:
    n = cellular(rng).network
    return {"positions": n.positions, "radii": n.radii, "threshold": 0.01, "cell": n.cell}


def _lists(rng: Rng) -> Arguments:
    n = cellular(rng).network
    half = n.contacts // 2
    return {
        "pairs": n.pairs[:half], "images": n.images[:half], "true_pairs": n.pairs,
        "true_images": n.images,
    }  # fmt: skip


def _list_error(rng: Rng) -> Arguments:
    f = rng.standard_normal(10)
    places = np.array([0, 2]), np.array([1, 3])
    true = rng.standard_normal(12)
    return {"forces": f, "true_forces": true, "matched": places, "frictional": True}


def _with(draw: Rng, *names: str, periodic: bool = False, **more: Any) -> Arguments:
    s = cellular(draw) if periodic else sample(draw)
    given = {name: getattr(s, name) for name in names}
    return {
        "network": s.network,
        **given,
        **{k: v() if callable(v) else v for k, v in more.items()},
    }


def _record_with(**changes: Any) -> Any:
    """A foreign packing with some of its fields replaced."""
    rest = {k: v for k, v in changes.items() if k != "packing"}
    record = copy.copy(changes["packing"])
    if isinstance(record, SimpleNamespace):
        vars(record).update(rest)
    return record


def _foreign(rng: Rng) -> Arguments:
    record = sample(rng).record
    return {"packing": record, **vars(record)}


def _amplification_of(packing: Any, **fields: Any) -> Any:
    return scaling.amplification_of(_record_with(packing=packing, **fields))


def _from_packing(packing: Any, **fields: Any) -> Any:
    return scaling.ContactNetwork.from_packing(_record_with(packing=packing, **fields))


def _collapse(rng: Rng) -> Arguments:
    packings = [cellular(rng).record for _ in range(int(rng.integers(1, 3)))]
    return {
        "packings": packings, "xis": np.array([0.01, 0.1]), "rng": _seeded(rng), "draws": 1,
        "method": _pick(rng, "gppsz", "direct"), "noise": _pick(rng, "diameter", "relative"),
        "xi_max": 0.05,
    }  # fmt: skip


def _errors(rng: Rng) -> Arguments:
    s = sample(rng)
    return {"predicted": 1.1 * s.forces, "true": s.forces, "frictional": s.frictional}


def _posterior(rng: Rng) -> Arguments:
    s = cellular(rng)
    return {
        "network": s.network, "stiffness": 1.0, "friction": 0.3,
        "noise": noise_model(s.network, xi=1e-3), "pressure": s.pressure, "data": "all",
        "frictional": s.frictional, "prior": prior.Prior(), "gaps": bool(rng.random() < 0.3),
    }  # fmt: skip


def _sample_ends(rng: Rng) -> Arguments:
    f = rng.standard_normal(6)
    return {"low": f - 1, "high": f + 1, "true": f, "slack": 0.0}


SCALING: tuple[Call, ...] = (
    Call("ContactNetwork", _network, _arrays, 6),
    Call("ContactNetwork.from_packing", _from_packing, _foreign, 3),
    Call(
        "ContactNetwork.with_sizes",
        lambda network, **k: network.with_sizes(**k),
        lambda g: (lambda s: {
            "network": s.network, "radii": 1.01 * s.network.radii, "external": s.network.external,
            "low": None,
        })(sample(g)),
        steady=("network",),
    ),
    Call(
        "ContactNetwork.replaced",
        lambda network, **k: network.replaced(**k),
        lambda g: (lambda s: {
            "network": s.network, "positions": 1.01 * s.network.positions,
            "cell": 1.01 * s.network.cell, "radii": s.network.radii,
            "external": s.network.external, "normals": s.network.normals,
        })(cellular(g)),
        2,
        steady=("network",),
    ),
    Call(
        "ContactNetwork.inside",
        lambda network, **k: network.inside(**k),
        lambda g: (lambda s: {
            "network": s.network, "mask": np.arange(s.network.grains) < 2,
            "normal_forces": s.forces[: s.network.contacts],
            "tangential_forces": s.forces[: s.network.contacts],
        })(sample(g)),
        steady=("network",),
    ),
    Call(
        "ContactNetwork.without_rattlers",
        lambda network, **k: network.without_rattlers(**k),
        lambda g: {"network": sample(g).network, "frictional": True},
        0.5,
        steady=("network",),
    ),
    Call(
        "force_equation", scaling.force_equation, lambda g: _with(g, "frictional", winding=False)
    ),
    Call(
        "ForceEquation.rhs",
        lambda network, stiffness: scaling.force_equation(network).rhs(stiffness),
        lambda g: _with(g, stiffness=1.0),
        0.5,
        steady=("network",),
    ),
    Call("reconstruct", scaling.reconstruct, _reconstruct, 6, seconds=20.0),
    Call("reconstruct (two materials)", scaling.reconstruct, _two_materials, 2, seconds=20.0),
    Call("credible_intervals", _intervals, _told, 0.3, seconds=30.0),
    Call("relative_error", scaling.relative_error, _errors, 2),
    Call(
        "mean_force",
        scaling.mean_force,
        lambda g: (lambda s: {"forces": s.forces, "frictional": s.frictional})(sample(g)),
    ),
    Call(
        "perturb",
        scaling.perturb,
        lambda g: _with(g, xi=1e-3, rng=lambda: _seeded(g), noise=lambda: _pick(g, *NOISES)),
        2,
    ),
    Call("rescaled", scaling.rescaled, lambda g: _with(g, radii=0.1, positions=0.1)),
    Call("rounded", scaling.rounded, lambda g: _with(g, digits=3, radii=True, positions=True)),
    Call("tiled", scaling.tiled, lambda g: _with(g, periodic=True, copies=2)),
    Call(
        "tiled_forces", scaling.tiled_forces, lambda g: _with(g, "forces", periodic=True, copies=2)
    ),
    Call("stress", scaling.stress, lambda g: _with(g, "forces", area=_pick(g, 1.0, None))),
    Call(
        "to_pressure", scaling.to_pressure,
        lambda g: _with(g, "forces", "pressure", periodic=True),
    ),
    Call(
        "stiffness_response",
        scaling.stiffness_response,
        lambda g: (lambda s: {
            "network": s.network, "forces": s.forces,
            "spread": 0.01 * g.standard_normal(s.network.contacts), "frictional": s.frictional,
        })(sample(g)),
    ),
    Call(
        "forces_of_overlaps",
        scaling.forces_of_overlaps,
        lambda g: (lambda s: {
            "network": s.network, "overlaps": s.forces[: s.network.contacts], "stiffness": 1.0,
            "method": _pick(g, "gppsz", "direct", "balanced"), "frictional": s.frictional,
        })(sample(g)),
    ),
    Call("flat_guess", scaling.flat_guess, lambda g: _with(g, "pressure")),
    Call("gain", scaling.gain, _map, 2),
    Call("error_map", lambda **k: scaling.error_map(**k).per_contact, _map, 2),
    Call("worst_pattern", scaling.worst_pattern, _map),
    Call("cramer_rao", lambda **k: scaling.cramer_rao(**k).gain, _covariance, 2),
    Call(
        "amplification",
        scaling.amplification,
        lambda g: (lambda s: {
            "network": s.network, "method": _pick(g, "gppsz", "direct"),
            "noise": _pick(g, "diameter", "radius"), "forces": s.forces,
            "pressure": s.pressure or 1.0, "frictional": s.frictional,
            "winding": False, "stiffness": 1.0,
        })(sample(g)),
    ),
    Call("amplification_of", _amplification_of, _foreign, 2),
    Call(
        "ErrorMap.sample",
        lambda map, **k: map.sample(**k),
        lambda g: _made_map(g, rng=_seeded(g), draws=3),
        0.5,
        steady=("map",),
    ),
    Call(
        "ErrorMap.estimated_gain",
        lambda map, **k: map.estimated_gain(**k),
        lambda g: _made_map(g, rng=_seeded(g), probes=3),
        0.5,
        steady=("map",),
    ),
    Call("infer_contacts", scaling.infer_contacts, _inferred, 3),
    Call("confusion", contact_lists.confusion, _lists),
    Call("list_error", contact_lists.list_error, _list_error),
    Call("collapse", collapse.collapse, _collapse, 0.6),
    Call(
        "noise_model",
        noise_model,
        lambda g: _with(g, noise=lambda: _pick(g, *NOISES), xi=1e-3),
    ),
    Call(
        "noise_model (covariance)",
        lambda network, covariance: noise_model(network, covariance=covariance),
        lambda g: {k: v for k, v in _covariance(g).items() if k in ("network", "covariance")},
    ),
    Call("loop_shares", prefactor.loop_shares, lambda g: _with(g, "frictional"), 0.7),
    Call("self_stress_gain", prefactor.self_stress_gain, lambda g: _with(g, "frictional"), 0.7),
    Call("size_response", conventions.size_response, lambda g: _with(g, noise="diameter"), 0.3),
    Call("balance_response", conventions.balance_response, lambda g: _with(g, "forces"), 0.3),
    Call("posterior", posterior.posterior, _posterior, 2),
    Call("Prior", prior.Prior, lambda g: {"mean": 1.0, "normal": 1.0, "tangential": 0.5}, 0.5),
    Call(
        "posterior_draws",
        lambda draws, rng: posterior_draws(problem(), rng, draws),
        lambda g: {"rng": _seeded(g), "draws": 2},
        0.15,
        seconds=30.0,
    ),
    Call(
        "truncated_draws",
        lambda draws, rng, burn_in: truncated_draws(problem(), rng, draws, burn_in=burn_in),
        lambda g: {"rng": _seeded(g), "draws": 2, "burn_in": 2},
        0.15,
        seconds=30.0,
    ),
    Call(
        "posterior_intervals",
        lambda **k: credible_intervals.posterior_intervals(problem(), **k),
        lambda g: {
            "rng": _seeded(g), "draws": 4, "level": 0.5,
            "method": _pick(g, "projected", "exact"), "spread": 2.0,
        },
        0.1,
        seconds=30.0,
    ),
    Call(
        "widened", lambda spread: credible_intervals.widened(problem(), spread),
        lambda g: {"spread": 2.0}, 0.3,
    ),
    Call(
        "enclosing",
        credible_intervals.enclosing,
        lambda g: {"sample": g.standard_normal((30, 4)), "level": 0.9},
        0.5,
    ),
    Call("coverage", credible_intervals.coverage, _sample_ends, 0.5),
)  # fmt: skip
