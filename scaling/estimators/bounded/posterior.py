"""What `bounded` knows: a prior, data and how good they are, friction and the pressure.

Σ f_n r = 2 p A  of a periodic cell,  -Σ x·F  of the loads if open;   f̄ = Σ f_n r/Σ r
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import (
    choice,
    finite_number,
    flag,
    instance,
    number_from_zero,
    positive_number,
)
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.equation.loads import refuse_unbalanced
from scaling.equation.mechanisms import refuse_mechanisms
from scaling.estimators.plausibility import refuse_deep_overlaps
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import Sources


@dataclass(frozen=True)
class Prior:
    """What forces are before any geometry is measured, in units of f̄.

    mean : of f_n, finite; normal, tangential : standard deviations of f_n and f_t, positive
    """

    mean: float = 1.0
    normal: float = 1.0
    tangential: float = 0.5

    def __post_init__(self) -> None:
        finite_number("prior: mean", self.mean)
        positive_number("prior: normal", self.normal)
        positive_number("prior: tangential", self.tangential)


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is minimised, and the linear data model; see `bounded_forces`."""

    equation: ForceEquation
    stiffness: float
    noise: Sources | None
    friction: float
    virial: float
    data: str
    prior: Prior
    gaps: bool = False

    @property
    def lengths(self) -> Floats:
        """r (c,) as far as data go: r̃, or σ̃ if sizes are all, or ⟨σ⟩ if nothing is."""
        network = self.equation.network
        if self.noise is None:
            return np.full(network.contacts, network.mean_diameter)
        return network.distances if self.data == "all" else network.sigma

    @property
    def mean_force(self) -> float:
        """f̄ = Σ f_n r/Σ r, the unit of the programme and the mean of the prior."""
        return self.virial / float(self.lengths.sum())

    @property
    def scatter(self) -> Floats:
        """(c,) standard deviations of the overlaps over ξ, a length; zeros if nothing is known."""
        if self.noise is None:
            return np.zeros(self.equation.network.contacts)
        B = self.noise.overlaps(self.equation.network)
        return np.sqrt(np.asarray(B.multiply(B).sum(axis=1)).ravel())


def posterior(
    network: ContactNetwork,
    stiffness: float,
    friction: float | None,
    noise: Sources | None,
    *,
    pressure: float | None = None,
    data: str = "all",
    frictional: bool = True,
    prior: Prior | None = None,
    gaps: bool = False,
) -> Posterior:
    """Collect a posterior; `noise` None means that neither sizes nor distances are known (ξ = ∞).

    `friction` is not used, and may be None, with frictional=False. With `gaps` (for data="all")
    a contact of the list may be open, f_n = κ (σ - r + gap) with gap >= 0 of exponential prior,
    its mean the standard deviation of σ̃ - r̃: for lists inferred from the geometry, where some
    are false. ValueError: bad input, or gaps where a contact is known without noise.
    """
    instance("network", network, ContactNetwork)
    positive_number("stiffness", stiffness)
    choice("data", data, ("all", "sizes"))
    if noise is not None:
        instance("noise", noise, Sources, ": see scaling.noise.noise_model")
    if prior is not None:
        instance("prior", prior, Prior)
    if flag("gaps", gaps) and (data != "all" or noise is None):
        raise ValueError("gaps are for data='all' with noise of finite strength")
    if friction is None:
        if flag("frictional", frictional):
            raise ValueError("a posterior with friction needs the friction coefficient")
        friction = 0.0
    number_from_zero("friction", friction)
    if data == "sizes" and noise is not None and noise.moves:
        raise ValueError("data='sizes' takes directions as exact: position noise needs data='all'")
    if noise is not None:
        refuse_deep_overlaps(network)
    equation = force_equation(network, flag("frictional", frictional))
    refuse_unbalanced(equation)
    refuse_mechanisms(equation)
    collected = Posterior(
        equation,
        stiffness,
        noise,
        friction,
        virial_of(network, pressure),
        data,
        Prior() if prior is None else prior,
        gaps,
    )
    if gaps and not collected.scatter.all():
        e = int(np.argmin(collected.scatter))
        raise ValueError(f"gaps: the overlap of contact {e} is known without noise")
    return collected


def virial_of(network: ContactNetwork, pressure: float | None) -> float:
    """Σ f_n r: 2 p A of a periodic cell, -Σ x·F of the loads if open.

    ValueError else, for a cell that no contacts wind, which then carry no pressure, and for a
    periodic cell with loads: what they add to Σ f_n r depends on where the cell is cut.
    """
    if network.cell is not None:
        if pressure is None:
            raise ValueError("pressure None: a periodic network needs a positive one")
        p = positive_number("pressure", pressure)
        if not network.forest.winding_rank.any():
            raise ValueError(
                f"pressure {p:g}: no component of the contact network winds the periodic cell, "
                "so nothing in it can carry a pressure"
            )
        pushed = network.external[:, :2].any(axis=1)
        if pushed.any():
            i = int(np.argmax(pushed))
            F = network.external[i, :2]
            raise ValueError(
                f"the pressure of a periodic cell does not give Σ f_n r with loads: grain {i} has "
                f"({F[0]:.3g}, {F[1]:.3g}), one of {pushed.sum()}"
            )
        return 2 * p * abs(float(np.linalg.det(network.cell)))
    if pressure is not None:
        raise ValueError("method 'bounded' does not use pressure if the network is open")
    if network.positions is None:
        raise ValueError("the loads on an open network give Σ f_n r only with positions")
    virial = -float(np.sum(network.positions * network.external[:, :2]))
    if not virial > 0:
        raise ValueError(f"the external loads do not compress: -Σ x·F = {virial:.3g}")
    return virial


def flat_guess(network: ContactNetwork, pressure: float | None = None) -> Floats:
    """(2c,) the guess that knows only the load: f_n = f̄ = Σ f_n r/Σ r everywhere, f_t = 0."""
    instance("network", network, ContactNetwork)
    fn = np.full(network.contacts, virial_of(network, pressure) / _lengths(network).sum())
    return np.concatenate([fn, np.zeros_like(fn)])


def _lengths(network: ContactNetwork) -> Floats:
    return network.sigma if network.positions is None else network.distances
