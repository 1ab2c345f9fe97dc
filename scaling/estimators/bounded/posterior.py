"""What `bounded` knows: a prior, data and how good they are, friction and the pressure.

    f̄ = Σ f_n r/Σ r ,    Σ f_n r = 2 p A in a periodic cell,  -Σ x·F if open

f̄ is the mean normal force, weighed with the distances r of the centres; p is the pressure, A
the area of the cell, and F the load on the grain at x. Of a cell whose pressure nobody knows
Σ f_n r is first taken from the overlaps; f̄ is then no more than a unit, and the mean of the prior
is found with the forces.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import choice, flag, instance, number_from_zero
from packing.contact_law import ContactLaw
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.equation.loads import refuse_unbalanced
from scaling.equation.mechanisms import refuse_mechanisms
from scaling.equation.virial import virial_of
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.plausibility import refuse_deep_overlaps
from scaling.estimators.told.datum import Told, is_unknown
from scaling.estimators.told.loads import load_errors
from scaling.estimators.told.mean_stress import (
    NOTHING,
    MeanStress,
    mean_stress,
    refuse_free_grains,
)
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import NoiseModel

SEEN = 3.0
"""Standard errors by which the overlaps have to press, for the scale of forces to be theirs."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is minimised, and the linear data model; see `scaling.estimators.bounded.maximum`."""

    equation: ForceEquation
    noise: NoiseModel | None
    friction: float
    virial: float
    data: str
    prior: Prior
    gaps: bool = False
    stress: MeanStress = NOTHING
    load_errors: csr_array = field(default_factory=lambda: csr_array((0, 0)))
    """E (rows of M, l) of `scaling.estimators.told.loads`."""
    closed: Floats | None = None
    """(c,) probability that each contact bears a force; None: all do."""

    @property
    def floats(self) -> bool:
        """Whether the mean force is not known exactly, and found with the forces."""
        area = self.equation.network.boundary.area
        if self.equation.network.free.any():
            return False
        if self.equation.balance_rhs().any():
            return False  # loads say how large forces are
        return area is not None and self.prior.mean != 0 and not self.stress.fixes_trace

    @property
    def stiffness(self) -> float:
        """κ, of a stiffness per contact the mean."""
        return self.equation.stiffness

    @property
    def lengths(self) -> Floats:
        """r (c,) as far as data go: r̃, or σ̃ if sizes are all, or ⟨σ⟩ if nothing is."""
        network = self.equation.network
        if self.noise is None:
            return np.full(network.contacts, network.mean_diameter)
        return network.distances if self.data == "all" else network.sigma

    @property
    def mean_force(self) -> float:
        """f̄ = Σ f_n r/Σ P r, unit of the program and mean of the prior; P = 1 unless told."""
        weights = 1.0 if self.closed is None else self.closed
        return self.virial / float((weights * self.lengths).sum())

    @property
    def scatter(self) -> Floats:
        """(c,) standard deviations of f_n/κ over ξ, lengths; zeros if nothing is known."""
        if self.noise is None:
            return np.zeros(self.equation.network.contacts)
        B = self.equation.stiffened(self.noise.overlaps(self.equation.network))
        return np.sqrt(np.asarray(B.multiply(B).sum(axis=1)).ravel())


def posterior(
    network: ContactNetwork,
    stiffness: ArrayLike | ContactLaw,
    friction: float | None,
    noise: NoiseModel | None,
    *,
    frictional: bool = True,
    **known: Any,
) -> Posterior:
    """`posterior_of` the equation of a network: its short form, `known` as there."""
    instance("network", network, ContactNetwork)
    equation = force_equation(network, flag("frictional", frictional))
    return posterior_of(equation.with_law(stiffness), friction, noise, **known)


def posterior_of(  # noqa: PLR0913  (what is known)
    equation: ForceEquation,
    friction: float | None,
    noise: NoiseModel | None,
    *,
    pressure: Told | None = None,
    data: str = "all",
    prior: Prior | None = None,
    gaps: bool = False,
    stress: Mapping[str, Told] | None = None,
    loads: ArrayLike | None = None,
    closed: ArrayLike | None = None,
) -> Posterior:
    """Collect a posterior; `noise` None means that neither sizes nor distances are known (ξ = ∞).

    `friction` is not used, and may be None, without tangential forces. With `gaps` (for
    data="all") a contact of the list may be open, f_n = κ (σ - r + gap) with gap >= 0 of
    exponential prior, its mean the standard deviation of σ̃ - r̃: for lists inferred from the
    geometry, where some are false. `pressure`, components of the mean `stress` and errors of the
    `loads` as in `scaling.estimators.told`. ValueError: bad input, or gaps where a contact is
    known without noise. `closed` (c,): probabilities that contacts bear a force at all, see
    `scaling.estimators.told.contacts`.
    """
    network = equation.network
    choice("data", data, ("all", "sizes"))
    if noise is not None:
        instance("noise", noise, NoiseModel, ": see scaling.noise.noise_model")
    if prior is not None:
        instance("prior", prior, Prior)
    if flag("gaps", gaps) and (data != "all" or noise is None):
        raise ValueError("gaps are for data='all' with noise of finite strength")
    friction = _friction(equation, friction)
    if data == "sizes" and noise is not None and noise.moves:
        raise ValueError("data='sizes' takes directions as exact: position noise needs data='all'")
    if noise is not None:
        refuse_deep_overlaps(network)
    errors = _errors_of(equation, loads)
    prior = Prior() if prior is None else prior
    told = mean_stress(pressure, stress)
    seen = noise if data == "all" else None
    if network.free.any() or (network.boundary.area is None and errors.shape[1]):
        virial = _virial_of_part(equation, told, errors, seen)
    else:
        virial = _likely_virial(equation, told, seen if is_unknown(pressure) else None)
    collected = Posterior(
        equation, noise, friction, virial, data, prior, gaps, told, errors,
        _probabilities(closed, network.contacts),
    )  # fmt: skip
    if gaps and not collected.scatter.all():
        e = int(np.argmin(collected.scatter))
        raise ValueError(f"gaps: the overlap of contact {e} is known without noise")
    return collected


def _probabilities(closed: ArrayLike | None, contacts: int) -> Floats | None:
    if closed is None:
        return None
    P = real_array("closed", closed, (contacts,), "contact")
    if ((P <= 0) | (P > 1)).any():
        e = int(np.argmax((P <= 0) | (P > 1)))
        raise ValueError(f"closed: contact {e} has the probability {P[e]:g}, expected 0 < P <= 1")
    return P


def _friction(equation: ForceEquation, friction: float | None) -> float:
    if friction is None:
        if equation.frictional:
            raise ValueError("a posterior with friction needs the friction coefficient")
        friction = 0.0
    return number_from_zero("friction", friction)


def _errors_of(equation: ForceEquation, loads: ArrayLike | None) -> csr_array:
    """E of the loads told; loads without error bars have to balance."""
    if loads is None:
        refuse_unbalanced(equation)
        refuse_mechanisms(equation)
    return load_errors(equation, loads)


def _likely_virial(equation: ForceEquation, told: MeanStress, noise: NoiseModel | None) -> float:
    """Σ f_n r that the loads or the stress told say; else, of a cell, what the overlaps say.

    `noise`: that of the overlaps, if they may be asked. ValueError: nothing says it, or overlaps
    that scatter about 0.
    """
    network, likely = equation.network, told.likely_pressure
    area = network.boundary.area
    if area is None and told.components:
        raise ValueError("the mean stress of an open network follows from its loads: tell none")
    if area is None or likely is not None or noise is None:
        return virial_of(network, likely)
    if network.walls is None and not network.forest.winding_rank.any():
        return virial_of(network, 1.0)  # refused: nothing carries a pressure
    return _virial_of_overlaps(equation, noise)


def _virial_of_part(
    equation: ForceEquation, told: MeanStress, errors: csr_array, noise: NoiseModel | None
) -> float:
    """Σ f_n r of a network with free grains, or whose loads have error bars: of these loads if
    they say it, else of the overlaps. It is the scale of the prior, and no condition."""
    network = equation.network
    if told.data:
        refuse_free_grains(equation)
        raise ValueError("the mean stress of an open network follows from its loads: tell none")
    if not network.free.any() and network.positions is not None:
        x = network.positions[network.active]
        arm = np.zeros(equation.M.shape[0])
        arm[: x.size] = (x - x.mean(axis=0)).T.ravel()
        virial = float(arm @ equation.balance_rhs())
        if virial > SEEN * float(np.linalg.norm(arm @ errors)):
            return virial
    if noise is None:
        raise ValueError(
            "neither loads nor overlaps tell the scale of the forces: where grains are free, or "
            "loads poorly known, overlaps of finite noise are needed"
        )
    return _virial_of_overlaps(equation, noise)


def _virial_of_overlaps(equation: ForceEquation, noise: NoiseModel) -> float:
    network = equation.network
    weighed = equation.stiffened(network.distances * equation.stiffness)
    virial = float(weighed @ network.overlaps)
    error = noise.xi * float(np.linalg.norm(noise.overlaps(network).T @ weighed))
    if not virial > SEEN * error:
        raise ValueError(
            f"pressure unknown: overlaps give Σ f_n r = {virial:.3g} ± {error:.3g}, which tells "
            "no scale of the forces: a pressure with its error bar is needed"
        )
    return virial
