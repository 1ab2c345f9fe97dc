"""One step of a derivation: a statement, its formula, its reason and its machine check."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy import Expr


@dataclass(frozen=True)
class Step:
    """One step of the derivation.

    Attributes:
        name: short handle, unique.
        statement: what is claimed, in words.
        latex: the formula.
        because: what it follows from.
        check: differences that must all vanish.
    """

    name: str
    statement: str
    latex: str
    because: str
    check: tuple[Expr, ...]

    @property
    def holds(self) -> bool:
        """Whether every difference simplifies to zero; a step with none does not hold."""
        return bool(self.check) and all(sp.simplify(difference) == 0 for difference in self.check)

    def _repr_markdown_(self) -> str:
        verdict = "holds" if self.holds else "**DOES NOT HOLD**"
        return (
            f"**{self.name}.** {self.statement}\n\n$${self.latex}$$\n\n"
            f"*because* {self.because}; *checked:* {len(self.check)} differences, {verdict}."
        )
