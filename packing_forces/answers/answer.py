"""What a verb hands back: lines to be read, and the same as plain values for other programs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

ANSWERED, REFUSED, WRONG_USAGE = 0, 1, 2
"""Exit codes."""


class Refused(Exception):
    """The data do not allow an answer; the message names the culprit and the number."""


@dataclass(frozen=True)
class Answer:
    """The answer of a verb.

    Parameters
    ----------
    lines : tuple of str
        For a terminal
    facts : mapping
        The same as numbers, text, lists and mappings, for ``--json``
    code : int
        Exit code, 1 where the answer is that the data forbid one
    """

    lines: tuple[str, ...]
    facts: Mapping[str, Any] = field(default_factory=dict)
    code: int = ANSWERED

    def text(self, as_json: bool = False) -> str:
        """What is printed."""
        if as_json:
            return json.dumps(plain(self.facts), ensure_ascii=False, indent=1)
        return "\n".join(self.lines)


def plain(value: Any) -> Any:
    """Values that JSON has: arrays become lists, and what is not finite becomes null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    return str(value)
