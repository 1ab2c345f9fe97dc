"""One step of a derivation: a statement, its formula, its reason and its machine check."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy import Expr
from sympy.core.function import AppliedUndef

#: Thirty digits are evaluated: what is larger is not zero.
TINY = sp.Float("1e-15")


def vanishes(difference: Expr) -> bool:
    """Whether sympy finds an expression to be zero for all values of its symbols.

    One value that is not zero settles the matter. Simplifying, which may take minutes, is then
    not needed.
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
    """One step of a derivation, with the differences that prove it.

    Parameters
    ----------
    name : str
        A short handle, unique within its derivation.
    statement : str
        What is claimed, in words.
    latex : str
        The formula.
    because : str
        What it follows from.
    check : tuple of sympy.Expr
        Differences that must all vanish.

    Attributes
    ----------
    holds : bool
        Whether sympy simplifies every difference to zero. A step without any does not hold.

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import Step
    >>> x = sp.Symbol("x")
    >>> square = (x + 1) ** 2 - x**2 - 2 * x - 1
    >>> Step("square", "A square expands.", "(x+1)^2=x^2+2x+1", "products", (square,)).holds
    True
    >>> Step("wrong", "A square is a cube.", "x^2=x^3", "nothing", (x**2 - x**3,)).holds
    False
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
