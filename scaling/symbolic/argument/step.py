"""One step of a derivation: a statement, its formula, its reason and its machine check."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy import Expr
from sympy.core.function import AppliedUndef

#: thirty digits are evaluated: what is larger is not zero
TINY = sp.Float("1e-15")


def vanishes(difference: Expr) -> bool:
    """Whether sympy finds an expression to be zero for all values of its symbols.

    One value that is not zero settles the matter without simplifying, which may take minutes.
    """
    difference = sp.sympify(difference)
    if difference.is_Number:
        return bool(difference == 0)
    if not difference.atoms(AppliedUndef):
        names = sorted(difference.free_symbols, key=str)
        at = {name: sp.Rational(sp.prime(k + 5), sp.prime(k + 9)) for k, name in enumerate(names)}
        value = difference.subs(at).evalf(30)
        if value.has(sp.nan, sp.zoo, sp.oo) or (value.is_comparable and abs(value) > TINY):
            return False
    return bool(sp.cancel(difference) == 0 or sp.simplify(difference) == 0)


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
        return bool(self.check) and all(vanishes(difference) for difference in self.check)

    def _repr_markdown_(self) -> str:
        verdict = "holds" if self.holds else "**DOES NOT HOLD**"
        return (
            f"**{self.name}.** {self.statement}\n\n$${self.latex}$$\n\n"
            f"*because* {self.because}; *checked:* {len(self.check)} differences, {verdict}."
        )
