"""The table behind the Comment's Fig. 1: error against noise, packing by packing.

    E(ξ, Δ) = C ξ/Δ    for size noise, exactly linear:   f(ξ) - f(0) = κ G⁺(0 ; Q δσ)

so that all packings fall on one line when ξ is divided by their Δ, and on none when it is not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing.arguments.arrays import Floats, real_array
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import generator, positive_number, real_number, shown, whole_number
from packing.contacts import contact_list
from packing.packing_like import fields_of
from scaling.algebra.probes import Probing
from scaling.equation.force_equation import force_equation
from scaling.estimators.table import informed, linear_names
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import NonPositiveRadius, check_noise, perturb
from scaling.uncertainty.amplification import amplification_of, nonlinear_law
from scaling.uncertainty.relative_error import relative_error

_PER_ROW = 500
"""Bytes of a row, in the list and in the array made of it."""

TABLE = np.dtype(
    [
        ("packing", np.int64),
        ("delta", float),
        ("xi", float),
        ("ratio", float),
        ("draw", np.int64),
        ("error", float),
        ("error_normal", float),
        ("C", float),
    ]
)
"""Columns: number of the packing; its Δ; ξ in units of ⟨σ⟩; ξ/Δ; number of the draw;
E over all components; rms(δf_n)/⟨f_n⟩; the exact prefactor C."""


def collapse(
    packings: Iterable[Any],
    xis: ArrayLike,
    rng: np.random.Generator,
    *,
    draws: int = 1,
    method: str = "gppsz",
    noise: str = "diameter",
    xi_max: float = 0.05,
    probes: int | Probing | None = None,
    **options: Any,
) -> NDArray:
    """Reconstruct every packing from noisy data; one row per packing, strength and draw.

    Parameters
    ----------
    packings : iterable
        With the fields of a network, and `forces` (2c or c), `stiffness`, `pressure`, `delta`, and
        with a `law` if that is not linear
    xis : array_like
        Strengths of the noise in units of each packing's Δ, positive
    rng : numpy.random.Generator
        Every (packing, strength, draw) gets a child generator of its own, so more packings or
        draws leave the others as they are
    draws : int
        Of the noise, for every packing and strength
    method, noise : str
        See `reconstruct` and `perturb`; a method is told what it asks for: the noise, or the true
        normal forces
    xi_max : float
        Strengths ξ above it are left out, and so are draws that make a radius negative: up to
        ξ = 0.05 and with radii within ±30 % a 7σ event, even for `radius` noise
    probes : int or Probing, optional
        Behind C, see `gain`: None is exact for up to 2048 sources of noise, and from 128 probes
        beyond
    **options : object
        Of the estimator, besides what it is told

    Returns
    -------
    numpy.ndarray
        A structured array with the columns of `scaling.uncertainty.collapse.TABLE`.

    Raises
    ------
    ValueError
        Bad input, naming argument and value.

    Notes
    -----
    The table behind Fig. 1 of DeGiuli and McElwaine, PRL 116, 078001 (2016).

    Examples
    --------
    >>> import numpy as np
    >>> from types import SimpleNamespace
    >>> from scaling import collapse
    >>> pushed = SimpleNamespace(
    ...     positions=[[0, 0], [0.99, 0]], radii=[0.5, 0.5], pairs=[(0, 1)], forces=[0.01],
    ...     external=[[0.01, 0, 0], [-0.01, 0, 0]], stiffness=1.0, pressure=0.01, delta=0.01)
    >>> table = collapse([pushed], [0.1], np.random.default_rng(0), draws=3, method="direct")
    >>> table["draw"].tolist(), table["xi"].tolist()
    ([0, 1, 2], [0.001, 0.001, 0.001])
    """
    ratios = _strengths(xis)
    if not (isinstance(method, str) and method in linear_names()):
        known = ", ".join(linear_names())
        raise ValueError(f"method {shown(method)} is unknown; linear ones are {known}")
    check_noise(noise)
    rng, xi_max = generator("rng", rng), real_number("xi_max", xi_max)
    if not xi_max > 0:
        raise ValueError(f"xi_max = {xi_max}: the largest strength must be positive")
    draws = whole_number("draws", draws, 1)
    packings = _listed(packings)
    refuse_beyond(
        f"draws = {shown(draws)} would make {_rows(packings, ratios, draws):.3g} rows",
        _PER_ROW * _rows(packings, ratios, draws),
    )
    rows: list[tuple] = []
    for k, (packing, child) in enumerate(zip(packings, rng.spawn(len(packings)), strict=True)):
        truth = _Truth.of(packing, method, noise, probes, options)
        of_packing = truth.drawn(ratios, child, draws, xi_max)
        rows += [(k, truth.delta, *row, truth.C) for row in of_packing]
    return np.array(rows, dtype=TABLE)


@dataclass(frozen=True, eq=False)
class _Truth:
    """A packing, its forces, and the method and noise whose errors are looked at."""

    network: ContactNetwork
    forces: Floats
    frictional: bool
    stiffness: Any
    delta: float
    method: str
    noise: str
    options: Mapping[str, Any]
    C: float

    @classmethod
    def of(
        cls,
        packing: Any,
        method: str,
        noise: str,
        probes: int | Probing | None,
        options: Mapping[str, Any],
    ) -> _Truth:
        """The fields of the packing, checked, and its prefactor."""
        network = ContactNetwork.from_packing(packing)
        more = fields_of(packing, ("forces", "stiffness", "pressure", "delta"))
        true, frictional = contact_list.forces(more["forces"], network.contacts)
        delta = positive_number("delta", more["delta"])
        C = amplification_of(packing, method, noise, probes=probes, **options)
        law = nonlinear_law(packing)
        law = more["stiffness"] if law is None else law
        return cls(network, true, frictional, law, delta, method, noise, options, C)

    def drawn(
        self, ratios: Floats, rng: np.random.Generator, draws: int, xi_max: float
    ) -> Iterator[tuple[float, float, int, float, float]]:
        """ξ, ξ/Δ, the number of the draw, and its errors."""
        for ratio, stream in zip(ratios, rng.spawn(len(ratios)), strict=True):
            ξ = float(ratio * self.delta)
            if ξ > xi_max:
                continue
            for draw, source in enumerate(stream.spawn(draws)):
                with suppress(NonPositiveRadius):
                    noisy = perturb(self.network, ξ, source, self.noise)
                    yield ξ, ratio, draw, *self.errors(noisy, ξ)

    def errors(self, noisy: ContactNetwork, xi: float) -> tuple[float, float]:
        """E, of all components and of the normal ones; the method is told what it asks for."""
        c = self.network.contacts
        known = {"normal_forces": self.forces[:c], "xi": xi, "noise": self.noise}
        equation = force_equation(noisy, self.frictional).with_law(self.stiffness)
        found = informed(self.method, known, self.options).solve(equation)
        return (
            relative_error(found.forces, self.forces, frictional=self.frictional),
            relative_error(found.normal, self.forces[:c], frictional=False),
        )


def _strengths(xis: ArrayLike) -> Floats:
    ratios = real_array("xis", xis, None, "strength")
    ratios = ratios.reshape(1) if ratios.ndim == 0 else ratios
    if ratios.ndim != 1:
        raise ValueError(f"xis has shape {ratios.shape}, expected (any,)")
    if (ratios <= 0).any():
        k = int(np.argmax(ratios <= 0))
        raise ValueError(f"xis[{k}] is {ratios[k]}: strengths must be positive")
    return ratios


def _listed(packings: Any) -> list[Any]:
    try:
        if isinstance(packings, str | bytes | dict):
            raise TypeError
        return list(packings)
    except TypeError:
        raise ValueError(f"packings = {shown(packings)} is no list of packings") from None


def _rows(packings: list[Any], ratios: Floats, draws: int) -> float:
    return float(len(packings)) * len(ratios) * min(draws, 10**100)
