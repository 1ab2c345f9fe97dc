"""Progress of a relaxation: how many orders of magnitude it is still from rest.

Three things have to come, and the one that is furthest away counts: the pressure, the speed, and
a polish that succeeds.  Whether it will is known only when it is tried, at the target speed.  So
the last decade of the bar is kept for it.  A polish that fails asks for a tenth of the speed, and
this further decade fills half of what was kept, the next half of the rest, and so on: the bar
never goes back, never stands still while the speed falls, and is full only at the end.
"""

from __future__ import annotations

from math import isfinite, log10
from types import TracebackType

from packing.progress import bar

#: Relaxation starts at speeds of order √(p/ρ), decade 0 of the bar.
_FASTEST = 1.0
#: Decades kept for the polish.
_KEPT = 1.0
#: Bars of what is mostly quick appear after so many seconds.
DELAY = 2.0


class _Bar:
    """A bar over ``total`` decades; leaving its block without an error fills it."""

    def __init__(self, total: float, title: str, progress: bool | None, delay: float) -> None:
        self._bar = bar(
            progress,
            total=total,
            desc=title,
            unit="decade",
            leave=False,
            delay=delay,
            bar_format="{desc} {bar} {postfix} [{elapsed} < {remaining}]",
        )

    @property
    def reached(self) -> float:
        """Decades behind us."""
        return self._bar.n

    @property
    def total(self) -> float:
        """Decades in all."""
        return self._bar.total

    def _reach(self, decades: float, text: str) -> None:
        if self._bar.disable:
            return
        self._bar.n = max(self.reached, round(decades, 3))
        self._bar.set_postfix_str(text, refresh=False)
        self._bar.update(0)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None and not self._bar.disable:
            self._bar.n = self._bar.total
            self._bar.update(0)
        self._bar.close()


class RelaxationBar(_Bar):
    """A bar over the decades still to go; leaving its block without an error fills it.

    ``target``: mean speed, in √(p/ρ), of the first polish; ``tolerance`` of the pressure.
    """

    def __init__(
        self,
        delta: float,
        target: float,
        limit: int,
        progress: bool | None,
        tolerance: float = 0.01,
    ) -> None:
        self._target, self._limit, self._tolerance = target, limit, tolerance
        self._decades = max(log10(_FASTEST / target), 1.0)
        self._begin, self._end, self._failures = 0.0, self._decades, 0
        super().__init__(self._decades + _KEPT, f"Δ={delta:.0e}", progress, 0.0)

    def __enter__(self) -> RelaxationBar:
        return self

    def show(self, step: int, speed: float, pressure_error: float = 0.0) -> None:
        """Report what is reached after ``step`` steps."""
        length = self._decades if self._failures == 0 else 1.0
        away = max(_decades(speed, self._target), _decades(pressure_error, self._tolerance))
        share = 1 - min(away / length, 1.0)
        tried = f", polish {self._failures + 1}" if self._failures else ""
        self._reach(
            self._begin + share * (self._end - self._begin),
            f"step {step} of at most {self._limit}, ⟨v⟩ {speed:.1e} → {self._target:.0e}{tried}",
        )

    def failed(self, target: float) -> None:
        """The polish failed; the next is due at the speed ``target``."""
        self._failures += 1
        self._target = target
        total = self._decades + _KEPT
        self._begin, self._end = self._end, 0.5 * (self._end + total)


def _decades(value: float, target: float) -> float:
    """How far ``value`` is above ``target``; infinitely before it is known."""
    if not isfinite(value):
        return float("inf")
    return max(log10(value / target), 0.0) if value > 0 else 0.0


class PressureBar(_Bar):
    """A bar over the decades of pressure from ``start`` to ``end``, shown if it takes long."""

    def __init__(self, title: str, start: float, end: float, progress: bool | None) -> None:
        self._start = start
        super().__init__(abs(log10(end / start)), title, progress, DELAY)

    def __enter__(self) -> PressureBar:
        return self

    def show(self, pressure: float) -> None:
        """Report the ``pressure`` reached."""
        self._reach(abs(log10(pressure / self._start)), f"Δ={pressure:.1e}")
