"""How noise in the data becomes error in the forces: exact to first order, without sampling.

At the noise-free solution G f = b, noise in b and G gives δf = G⁺(δb - δG f). The two
parts of the loop rows, κ δQ σ - δQ f_n = κ δQ r, combine with 0 = δ(Q r) to -κ Q δr, so

    sizes       δf = κ ξ G⁺ (     0     ;  Q A  ) η         A = ∂σ/∂η
    positions   δf = κ ξ G⁺ ( -δM f / κ ; -Q ∂r/∂x ) η

and with K = ‖G⁺(...)‖_F/√(2c) (c without friction) the error over noise draws is

    E_rms = K κ ξ / ⟨|f|⟩ = C ξ/Δ ,      C = K p / ⟨|f|⟩ ,      Δ = p/κ .

K is a length: K/⟨σ⟩ depends on the geometry alone, save for -δM f/κ = O(Δ). For size noise the
response is linear at any ξ. The method `direct` has δf_n = κ ξ A η (or -∂r/∂x) and
δf_t = -M_t⁺(M_n δf_n + δM f); `transverse` only the second, with exact normal forces.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from packing import contact_list
from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import choice, flag, instance, positive_number
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import (
    balance_response,
    check_moves,
    check_noise,
    distance_response,
    size_response,
)
from scaling.uncertainty.error_map import LINEAR, error_map, slope
from scaling.uncertainty.relative_error import mean_force

_BLOCK = 256  # noise sources per solve: bounds the memory to 2c × 256 numbers


def gain(
    network: ContactNetwork,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    frictional: bool = True,
    winding: bool = False,
    forces: ArrayLike | None = None,
    stiffness: float | None = None,
) -> float:
    """K, a length: E_rms = K κ ξ/⟨|f|⟩ for independent noise of strength ξ.

    Parameters
    ----------
    method : "gppsz", "direct", "transverse" (uses no sizes: 0 for size noise), "balanced" or
        "optimal"
    noise : "diameter", "radius", "relative" or "position"
    frictional : False: c normal forces, no torques
    winding : with the windings among the loops (gppsz only)
    forces : (2c,) or (c,), for position noise: adds -δM f. Without them directions are
        taken to be exact in M (an error of order Δ, and for `transverse` nothing would be left)
    stiffness : κ of these forces; by default the slope of f_n against the overlaps

    ValueError: bad input, an argument not used, or an equation without a unique solution.
    """
    instance("network", network, ContactNetwork)
    check_noise(noise)
    choice("method", method, LINEAR)
    flag("frictional", frictional)
    if flag("winding", winding) and method != "gppsz":
        raise ValueError(f"method {method!r} does not use winding")
    if noise != "position" and (forces is not None or stiffness is not None):
        raise ValueError(f"{noise} noise leaves G alone: forces and stiffness are not used")
    if forces is None and stiffness is not None:
        raise ValueError("stiffness is not used without forces")
    if stiffness is not None:
        stiffness = positive_number("stiffness", stiffness)
    if method == "transverse" and not frictional:
        raise ValueError("method 'transverse' finds tangential forces: frictional=False has none")
    if method == "transverse" and noise == "position" and forces is None:
        raise ValueError("method 'transverse' feels position noise through δM f: give forces")
    if noise == "position":
        check_moves(network)
    if method in ("balanced", "optimal"):
        return error_map(
            network, method, noise, frictional=frictional, forces=forces, stiffness=stiffness
        ).gain
    equation = force_equation(network, frictional, winding)
    f = None
    if forces is not None:
        f = real_array("forces", forces, (equation.unknowns,), "component")
    return _gain(equation, method, noise, f, stiffness)


def _gain(
    equation: ForceEquation,
    method: str,
    noise: str,
    forces: Floats | None,
    stiffness: float | None,
) -> float:
    network, matrices = equation.network, equation.matrices
    if noise == "position":
        normal = -distance_response(network)
        # ξ κ drops out: everything is per unit of κ.
        balance: Any = csr_array((matrices.M.shape[0], normal.shape[1]))
        if forces is not None:
            κ = slope(network, forces) if stiffness is None else stiffness
            balance = -balance_response(network, forces) / κ
    elif method == "transverse":
        return 0.0
    else:
        normal = size_response(network, noise)
        balance = csr_array((matrices.M.shape[0], normal.shape[1]))

    squares = 0.0
    for start in range(0, normal.shape[1], _BLOCK):
        some = slice(start, start + _BLOCK)
        δn, δb = normal[:, some].toarray(), balance[:, some].toarray()
        if method == "gppsz":
            squares += _square(matrices.system.solve(np.concatenate([δb, matrices.Q @ δn])))
            continue
        if method == "direct":
            squares += _square(δn)
            δb = δb - matrices.M_normal @ δn
        if equation.frictional:
            squares += _square(matrices.transverse.solve(δb))
    return float(np.sqrt(squares / equation.unknowns))


def amplification(
    network: ContactNetwork,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    forces: ArrayLike,
    pressure: float,
    frictional: bool = True,
    winding: bool = False,
    stiffness: float | None = None,
) -> float:
    """C = K p/⟨|f|⟩, the Comment's prefactor: E_rms = C ξ/Δ.

    Parameters: see `gain`; `forces` are the true ones, (2c,) or (c,), `pressure` p > 0 goes with
    them. For position noise they also enter K, with κ = `stiffness` (default: fitted).
    """
    instance("network", network, ContactNetwork)
    pressure = positive_number("pressure", pressure)
    check_noise(noise)
    unknowns = network.contacts * (2 if flag("frictional", frictional) else 1)
    f = real_array("forces", forces, (unknowns,), "component")
    mean = mean_force(f, frictional=frictional)
    if mean == 0:
        raise ValueError("the mean force is 0: there is no relative error")
    moving = noise == "position"
    K = gain(
        network,
        method,
        noise,
        frictional=frictional,
        winding=winding,
        forces=f if moving else None,
        stiffness=stiffness if moving else None,
    )
    return float(K * pressure / mean)


def amplification_of(packing: Any, method: str = "gppsz", noise: str = "diameter") -> float:
    """C of a packing: anything with the fields of a network, `forces`, `pressure`, `stiffness`.

    It is frictionless if it has c forces instead of 2c.
    """
    network = ContactNetwork.from_packing(packing)
    return amplification(
        network,
        method,
        noise,
        forces=packing.forces,
        pressure=packing.pressure,
        frictional=is_frictional(network, packing.forces),
        stiffness=packing.stiffness if noise == "position" else None,
    )


def is_frictional(network: ContactNetwork, forces: ArrayLike) -> bool:
    """Whether `forces` are (f_n ; f_t), 2c of them, or normal forces alone, c. Else refuse."""
    return contact_list.forces(forces, network.contacts)[1]


def _square(array: Floats) -> float:
    return float(np.sum(array**2))
