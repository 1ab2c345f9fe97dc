"""The field in which the directions of a small network live.

Sines and cosines are rational functions of u = tan(φ/2), so a network with free angles is
linear algebra over QQ(u, v), and one with regular polygons over QQ(tan π/n).  sympy's
DomainMatrix then finds ranks and inverses in seconds, exactly, where simplification of
trigonometric expressions takes minutes and may stop short of zero.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy as sp
from sympy import QQ, Expr, Matrix
from sympy.polys.matrices import DomainMatrix

from scaling.symbolic.loops.symbolic_network import SymbolicNetwork


class ExactField:
    """The field in which a network's directions live, and the way there and back."""

    def __init__(self, network: SymbolicNetwork) -> None:
        if len(network.fixed) > 1 or (network.fixed and network.sample):
            raise ValueError(f"{network.name}: one algebraic number or free parameters, not both")
        free = sorted(network.sample, key=str)
        self.convert: Callable[[Expr], Any]
        if network.fixed:
            ((symbol, value),) = network.fixed.items()
            self.domain = QQ.algebraic_field(value)
            generator = self.domain.from_sympy(self.domain.ext.as_expr())
            rational = QQ.frac_field(symbol)
            self.convert = lambda expr: self._evaluated(rational.from_sympy(expr), generator)
        else:
            self.domain = QQ.frac_field(*free) if free else QQ
            self.convert = self.domain.from_sympy if free else self._number

    def _number(self, expr: Expr) -> Any:
        return self.domain.from_sympy(sp.cancel(expr))

    def _evaluated(self, fraction: Any, generator: Any) -> Any:
        numerator, denominator = (
            self._horner(part.to_dense(), generator) for part in (fraction.numer, fraction.denom)
        )
        return numerator / denominator

    def _horner(self, coefficients: list[Any], point: Any) -> Any:
        total = self.domain.zero
        for coefficient in coefficients:
            total = total * point + self.domain.convert(coefficient)
        return total

    def matrix(self, dense: Matrix) -> DomainMatrix:
        """Return a sympy matrix over this field; each distinct entry is translated once."""
        known: dict[Expr, Any] = {}
        for entry in dense:
            if entry not in known:
                known[entry] = self.convert(entry)
        rows = [[known[dense[i, j]] for j in range(dense.cols)] for i in range(dense.rows)]
        return DomainMatrix(rows, dense.shape, self.domain)

    def expression(self, element: Any) -> Expr:
        """Return a field element as a sympy expression."""
        return self.domain.to_sympy(element)
