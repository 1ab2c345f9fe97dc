"""Numbers that know how they were found: exactly, or from random probes with an error bar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats


class Estimate(float):
    """A number with its standard error, and the probes that it took; of 0 probes it is exact.

    Parameters
    ----------
    value : float
        The number
    error : float
        One standard error, in its unit
    probes : int
        How many; 0 for an exact number, whose error is 0

    Notes
    -----
    Arithmetic gives plain numbers; `scaled` keeps the bar.

    Examples
    --------
    >>> K = Estimate(0.24, error=0.001, probes=128)
    >>> K, 2 * K, K.scaled(2.0).error
    (Estimate(0.24, error=0.001, probes=128), 0.48, 0.002)
    """

    error: float
    probes: int

    def __new__(cls, value: float, error: float = 0.0, probes: int = 0) -> Estimate:
        """The number, with what it knows."""
        made = super().__new__(cls, value)
        made.error, made.probes = float(error), int(probes)
        return made

    def __getnewargs__(self) -> tuple[float, float, int]:  # type: ignore[override]
        return float(self), self.error, self.probes

    def __repr__(self) -> str:
        if self.probes == 0:
            return float.__repr__(self)
        return f"Estimate({float(self)!r}, error={self.error!r}, probes={self.probes})"

    __str__ = float.__repr__

    @property
    def exact(self) -> bool:
        """Whether it took no probes."""
        return self.probes == 0

    def scaled(self, factor: float) -> Estimate:
        """`factor` times it, with its bar."""
        return Estimate(float(self) * factor, self.error * abs(factor), self.probes)

    def root(self) -> Estimate:
        """Its square root, to first order in the bar."""
        root = float(np.sqrt(self))
        return Estimate(root, self.error / (2 * root) if root > 0 else 0.0, self.probes)


@dataclass(frozen=True, eq=False)
class Estimates:
    """Many of them.

    Parameters
    ----------
    values, error : numpy.ndarray
        (n,) each
    probes : int
        0 for exact ones

    Examples
    --------
    >>> import numpy as np
    >>> some = Estimates(np.array([4.0]), np.array([0.4]), probes=128)
    >>> some.root().values.tolist(), some.root().error.tolist()
    ([2.0], [0.1])
    """

    values: Floats
    error: Floats
    probes: int

    @property
    def exact(self) -> bool:
        """Whether they took no probes."""
        return self.probes == 0

    def scaled(self, factor: float) -> Estimates:
        """`factor` times them."""
        return Estimates(factor * self.values, abs(factor) * self.error, self.probes)

    def root(self) -> Estimates:
        """Their square roots, to first order in the bars."""
        root = np.sqrt(self.values)
        error = np.divide(self.error, 2 * root, out=np.zeros_like(root), where=root > 0)
        return Estimates(root, error, self.probes)
