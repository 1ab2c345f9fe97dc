"""The noise that an estimator is told: options xi, noise, covariance and data, checked alike."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from packing.arguments.numbers import choice, real_number
from scaling.noise.conventions import NOISE

UNKNOWN = "unknown"
"""Said of a number that is to be found from the data."""


class ToldNoise(Protocol):
    """An estimator with these options."""

    @property
    def name(self) -> str:
        """As in the table of estimators."""

    @property
    def xi(self) -> float | str | None:
        """Strength of the noise, or "unknown"."""

    @property
    def noise(self) -> str:
        """Convention of the noise."""

    @property
    def covariance(self) -> ArrayLike | None:
        """Instead of both."""

    @property
    def data(self) -> str:
        """ "all", or "sizes"."""


def check_told_noise(asked: ToldNoise) -> None:
    """ValueError for an unknown convention or kind of data, or a strength that is no number."""
    choice("noise", asked.noise, NOISE)
    choice("data", asked.data, ("all", "sizes"))
    if isinstance(asked.xi, str):
        choice("xi", asked.xi, (UNKNOWN,))
        if asked.covariance is not None:
            raise ValueError("covariance says all about the noise: xi is not used with it")
    elif asked.xi is not None:
        real_number("xi", asked.xi)


def refuse_no_noise(asked: ToldNoise) -> None:
    """ValueError where no strength is told at all."""
    if asked.xi is None and asked.covariance is None:
        raise ValueError(
            f"method {asked.name!r} needs the strength of the noise: xi, or covariance"
        )


def told(asked: ToldNoise) -> str:
    """What was told, in a few words."""
    if asked.covariance is not None or asked.xi is None:
        return "covariance"
    strength = asked.xi if isinstance(asked.xi, str) else f"{asked.xi:g}"
    return f"xi = {strength}, {asked.noise}"
