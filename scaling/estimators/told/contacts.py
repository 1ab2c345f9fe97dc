"""Contacts that nobody lists, from gaps with noise: each pair is closed with a probability.

The gaps g = r - σ of pairs below a reach H are a mixture, of unknown numbers of contacts c and of
neighbours that do not touch, ρ of them per length:

    n(g) = c φ(g) + ρ Φ(g/s)                      g < H
    φ(g) = e^{g/δ̄ + s²/2δ̄²} Φ(-g/s - s/δ̄)/δ̄       overlaps of mean δ̄, exponential, and noise s
    P_closed = c φ(g)/n(g)

Φ is the normal distribution. c and ρ maximise the evidence Σ log n(g) - ∫ n, a concave function,
by the steps of EM. The pressure says δ̄ = f̄/κ, the noise of the data says s. With exact data
P is 1 for overlaps and 0 else; with s >> δ̄ it falls from c/(c + ρ √(π/2) s) at g = 0 on.

`bounded` takes the probabilities (`closed=`): the force of a pair is 0 with 1 - P, else of the
prior, so it is P f̄ with the variance of that mixture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtr
from scipy.stats import norm

from packing.arguments.arrays import Floats
from packing.arguments.immutable import Immutable
from packing.arguments.numbers import number_between, positive_number
from packing.contacts.contact_search import infer_contacts
from packing.packing_like import PackingLike
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import noise_model

REACH = 4.0
"""Deviations of the noise, and mean overlaps, up to which gaps are looked at."""
_STEPS, _CLOSE, _GRID = 10_000, 1e-10, 20_001
_TINY = np.finfo(float).tiny


@dataclass(frozen=True, eq=False)
class Mixture(Immutable):
    """Pairs closed and open, by their gaps.

    Attributes
    ----------
    closed : (pairs,) array
        The probability that each is closed
    contacts, density : float
        c and ρ, those of the largest evidence
    threshold : float
        The gap at which a pair is as probably closed as open
    """

    closed: Floats
    contacts: float
    density: float
    threshold: float

    @classmethod
    def of(cls, gaps: Floats, overlap: float, deviations: Floats, reach: float) -> Mixture:
        """Of all gaps g < `reach`, with the standard deviations s of their noise."""
        s = float(np.sqrt(np.mean(deviations**2)))
        touching = np.exp(_log_closed(gaps, overlap, deviations))
        apart = ndtr(gaps / deviations)
        z = reach / s
        length = s * float(z * ndtr(z) + norm.pdf(z))  # ∫ Φ(g/s) up to the reach; ∫ φ = 1
        c, ρ = len(gaps) / 2, len(gaps) / 2 / length
        for _ in range(_STEPS):
            share = c * touching / np.maximum(c * touching + ρ * apart, _TINY)
            last, c, ρ = c, float(share.sum()), float((1 - share).sum()) / length
            if abs(c - last) <= _CLOSE * len(gaps):
                break
        at = np.linspace(-reach, reach, _GRID)
        odds = np.log(max(c, _TINY)) - np.log(max(ρ, _TINY)) + _log_closed(at, overlap, s)
        even = np.flatnonzero(odds >= log_ndtr(at / s))
        return cls(share, c, ρ, float(at[even[-1]]) if len(even) else -reach)


@dataclass(frozen=True, eq=False)
class InferredContacts(Immutable):
    """Pairs that may touch, and how probably they do.

    Attributes
    ----------
    network : ContactNetwork
        Of all pairs that are closed with a probability of at least `least`, without rattlers
    closed : (c,) array
        The probability of each
    mixture : Mixture
        Of all pairs within reach, with the threshold that the evidence picks
    """

    network: ContactNetwork
    closed: Floats
    mixture: Mixture


def contacts_from_gaps(
    packing: PackingLike,
    overlap: float,
    xi: float,
    noise: str = "position",
    *,
    least: float = 0.1,
    frictional: bool = True,
) -> InferredContacts:
    """Contacts from positions and radii with noise, without any list.

    Parameters
    ----------
    packing : PackingLike
        Anything with positions and radii, and cell and loads if it has them; its contacts are
        not looked at
    overlap : float
        The mean overlap δ̄ of contacts, a length: f̄/κ, of order Δ
    xi, noise : float and str
        The strength of the noise and its kind, see `scaling.noise.noise_model`
    least : float
        Pairs that are closed with a smaller probability are left out, between 0 and 1

    Returns
    -------
    InferredContacts
        A network, and probabilities for `Bounded(closed=...)`.

    Raises
    ------
    ValueError
        Bad input, or no pair within reach.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> row = SimpleNamespace(
    ...     positions=[(0.0, 0.0), (0.99, 0.0), (1.97, 0.0), (3.2, 0.0)], radii=[0.5] * 4,
    ...     external=[(1.0, 0, 0), (0, 0, 0), (-1.0, 0, 0), (0, 0, 0)])
    >>> found = contacts_from_gaps(row, overlap=0.01, xi=1e-3)
    >>> found.network.pairs.tolist(), [f"{p:.2f}" for p in found.closed]
    ([[0, 1], [1, 2]], ['1.00', '1.00'])
    """
    overlap, least = positive_number("overlap", overlap), number_between("least", least, 0, 1)
    xi = positive_number("xi", xi)
    cell, loads = (getattr(packing, name, None) for name in ("cell", "external"))
    x, R = packing.positions, np.asarray(packing.radii, dtype=float)
    rough = REACH * (2 * xi * 2 * float(R.mean()) + overlap)
    pairs, images = infer_contacts(x, R, rough, cell=cell)
    if not len(pairs):
        raise ValueError(f"no pair of grains has a gap below {rough:.3g}: there is no contact")
    every = ContactNetwork(x, R, pairs, images=images, cell=cell, external=loads)
    model = noise_model(every, noise, xi=xi)
    B = model.overlaps(every) * xi
    s = np.sqrt(np.asarray(B.multiply(B).sum(axis=1)).ravel())
    found = Mixture.of(-every.overlaps, overlap, s, rough)
    closed = found.closed
    network = every.selected(closed >= least, every.external).without_rattlers(frictional)
    index = np.flatnonzero(closed >= least)[network.contact_index]
    return InferredContacts(network, closed[index], found)


def _log_closed(g: Floats, overlap: float, s: Floats | float) -> Floats:
    """log φ(g)."""
    return g / overlap + s**2 / (2 * overlap**2) + log_ndtr(-g / s - s / overlap) - np.log(overlap)
