"""Where a packing comes from: what it was asked to be, how it was made, how well it rests.

All of it is plain values (``packing.plain_values``), so that a file can hold it. None stands
for what nobody knows.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from packing.arguments.numbers import shown
from packing.plain_values import plain_dictionary, plain_value

Facts = dict[str, Any]


@dataclass(frozen=True)
class Provenance:
    """The origin of a packing.

    Parameters
    ----------
    scene : dict, optional
        What was asked for, the fields of a ``dem.Scene`` by name.
    seed : int, optional
        Of the random numbers of the start.
    settings : dict, optional
        How it was made, the fields of ``dem.Settings`` by name.
    backend : str, optional
        The kernel that moved the grains.
    versions : dict, optional
        Of the packages that made it, by name.
    steps : int, optional
        Time steps to rest.
    inertial_times : float, optional
        The same in ⟨σ⟩√(ρ/p).
    speed : float, optional
        Mean speed where time integration ended, in √(p/ρ).
    newton : int, optional
        Iterations of Newton's method.
    residual : float, optional
        Largest force, or torque over R, on a grain, in p⟨σ⟩.
    ramp : dict, optional
        Of a packing made by ``ramp``: ``from``, the Δ that it came from.
    continued : dict, optional
        Of a packing made by ``stiffen``: ``from``, and the ``stages`` and iterations since.
    notes : dict
        Anything else that somebody has written down.

    Raises
    ------
    ValueError
        Naming what no file could hold, a value of another type, a note by the name of a field.

    Examples
    --------
    >>> from packing.provenance import Provenance
    >>> Provenance(seed=1, notes={"by": "hand"}).plain()
    {'seed': 1, 'by': 'hand'}
    """

    scene: Facts | None = None
    seed: int | None = None
    settings: Facts | None = None
    backend: str | None = None
    versions: Facts | None = None
    steps: int | None = None
    inertial_times: float | None = None
    speed: float | None = None
    newton: int | None = None
    residual: float | None = None
    ramp: Facts | None = None
    continued: Facts | None = None
    notes: Facts = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, kind in _KINDS.items():
            value = plain_value(name, getattr(self, name))
            if not (value is None or _is_a(kind, value)):
                raise ValueError(f"{name} = {shown(value)} is no {_WORDS[kind]}")
            object.__setattr__(self, name, value)
        object.__setattr__(self, "notes", plain_dictionary("notes", self.notes))
        if twice := [name for name in self.notes if getattr(self, name, None) is not None]:
            raise ValueError(f"notes has the key {twice[0]!r}, and {twice[0]} is given, too")

    @classmethod
    def of_plain(cls, info: Any) -> Provenance:
        """From one dictionary, of ``plain`` or of an old file; what is no field becomes a note."""
        info = plain_dictionary("info", info)
        known = {k: info.pop(k) for k in _KINDS if k in info and _is_a(_KINDS[k], info[k])}
        return cls(**known, notes=info)

    def plain(self) -> Facts:
        """All that is known, as one new dictionary, notes beside the fields."""
        known = {name: getattr(self, name) for name in _KINDS}
        return plain_dictionary(
            "info", {k: v for k, v in known.items() if v is not None} | self.notes
        )

    def noted(self, **facts: Any) -> Provenance:
        """The same with other ``facts``: of fields, or notes."""
        known = {name: value for name, value in facts.items() if name in _KINDS}
        notes = self.notes | {k: v for k, v in facts.items() if k not in _KINDS}
        return replace(self, **known, notes={k: v for k, v in notes.items() if k not in known})


_WORDS: dict[type, str] = {
    dict: "dictionary", int: "whole number", float: "number", str: "text",
}  # fmt: skip
#: Of each field but the notes: what it holds, if it is known.
_KINDS: dict[str, type] = {
    "scene": dict, "seed": int, "settings": dict, "backend": str, "versions": dict, "steps": int,
    "inertial_times": float, "speed": float, "newton": int, "residual": float, "ramp": dict,
    "continued": dict,
}  # fmt: skip


def _is_a(kind: type, value: Any) -> bool:
    if isinstance(value, bool):
        return False
    return isinstance(value, (int, float) if kind is float else kind)
