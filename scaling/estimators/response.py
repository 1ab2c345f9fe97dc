"""What noise in the data does to the forces of a linear estimator: η -> δf/(κ ξ), to first order.

The noise η changes overlaps by ξ B η and, at the forces |f⟩, balance by ξ D η (see
`scaling.noise.noise_model`). φ = f/κ are forces as lengths; D goes with φ here, so that nothing in
the response knows the unit of force. Of a stiffness per contact κ is the mean.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from packing.progress import counted
from scaling.algebra.evidence import Solved
from scaling.algebra.probes import Probing, Squares, probed
from scaling.equation.force_equation import ForceEquation
from scaling.noise.noise_model import NoiseModel
from scaling.noise.source_places import source_places

BLOCK = 256
"""Sources of noise per solve: bounds the memory to 2c × 256 numbers."""
AUTOMATIC = Probing()
"""Exact for few sources, probes for many."""


class Responsive(Protocol):
    """An estimator whose forces are linear in the data."""

    @property
    def name(self) -> str:
        """As in the table of estimators."""

    def prepared(self, at: Response) -> Any:
        """What is solved with for every η, made once."""

    def respond(self, at: Response, η: Floats) -> Solved:
        """(k, m) noise -> (2c, m) lengths δf/(κ ξ); (c, m) if frictionless."""


@dataclass(frozen=True, eq=False)
class Response:
    """One estimator at one equation and noise model.

    `lengths` are the forces φ = f/κ (2c,) at which directions turn in M; None: directions count as
    exact there.
    """

    estimator: Responsive
    equation: ForceEquation
    noise: NoiseModel
    lengths: Floats | None = None

    @property
    def φ(self) -> Floats:
        """(2c,) `lengths`, or zeros."""
        return np.zeros(self.equation.unknowns) if self.lengths is None else self.lengths

    @cached_property
    def overlaps(self) -> csr_array:
        """B, (c, k) sparse."""
        return self.noise.overlaps(self.equation.network)

    @cached_property
    def balance(self) -> csr_array:
        """D, (rows of M, k) sparse, per κ."""
        return self.noise.balance(self.equation.network, self.φ)

    @cached_property
    def prepared(self) -> Any:
        """What the estimator solves with."""
        return self.estimator.prepared(self)

    def __call__(self, η: Floats) -> Floats:
        """(k, m) noise -> (2c, m) lengths; (c, m) if frictionless."""
        return self.solved(η).values

    def solved(self, η: Floats) -> Solved:
        """The response with its error, relative to what the noise does to the data."""
        return self.estimator.respond(self, η)

    def columns(self) -> Iterator[tuple[slice, Solved]]:
        """The response to each source by itself, some at a time."""
        k = self.noise.count
        blocks = range(0, k, BLOCK)
        for start in counted(blocks, len(blocks), f"error map of {self.estimator.name}"):
            stop = min(start + BLOCK, k)
            η = np.zeros((k, stop - start))
            η[np.arange(start, stop), np.arange(stop - start)] = 1.0
            yield slice(start, stop), self.solved(η)

    def squares(self, probing: Probing = AUTOMATIC) -> Squares:
        """(2c,) sums of squares over the sources: the variance of every component over (κ ξ)².

        Exact, or from random probes with error bars, as `probing` says.
        """
        k, rows = self.noise.count, self.equation.unknowns
        if count := probing.count(k):
            places = source_places(self.equation.network, self.noise)
            return probed(self, k if places is None else places, rows, count, probing.seed)
        total = np.zeros(rows)
        for _, some in self.columns():
            total += np.sum(some.values**2, axis=1)
        return Squares.exact(total)
