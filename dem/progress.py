"""Progress of a relaxation: Δ, step, speed against its target, time left.

Quiet unless standard error is a terminal.
"""

from __future__ import annotations

from math import isfinite, log10
from types import TracebackType

from tqdm import tqdm

#: Relaxation starts at speeds of order √(p/ρ), decade 0 of the bar.
_FASTEST = 1.0


class RestBar:
    """A bar over the decades of speed still to lose."""

    def __init__(self, delta: float, target: float, limit: int, progress: bool | None) -> None:
        self._target, self._limit = target, limit
        self._bar = tqdm(
            total=round(log10(_FASTEST / target), 2),
            desc=f"Δ={delta:.0e}",
            unit="decade",
            leave=False,
            disable=None if progress is None else not progress,
            bar_format="{desc} {bar} {postfix} [{elapsed} < {remaining}]",
        )

    def __enter__(self) -> RestBar:
        return self

    def show(self, step: int, speed: float) -> None:
        """Report the speed (in √(p/ρ)) reached after ``step`` steps."""
        if self._bar.disable:
            return
        if isfinite(speed):
            decades = log10(_FASTEST / speed) if speed > 0 else self._bar.total
        else:  # before the first look
            decades = 0.0
        self._bar.n = min(max(self._bar.n, round(decades, 2)), self._bar.total)
        text = f"step {step} of at most {self._limit}, ⟨v⟩ {speed:.1e} → {self._target:.0e}"
        self._bar.set_postfix_str(text, refresh=False)
        self._bar.update(0)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.close()
