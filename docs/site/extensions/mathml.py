"""Formulas become MathML while the site is built: browsers show it without script or network."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

CLOSE = re.compile(r"<mo(?: stretchy=\"false\")?>(&#x0007C;|&#x0002F;)</mo>")
"""The bars of |f⟩ and the slash of ξ/Δ: operators to MathML, which would set them wide apart."""


def inline(self: Any, node: nodes.math) -> None:
    """A formula in a line."""
    self.body.append(f'<span class="formula">{mathml(node.astext())}</span>')
    raise nodes.SkipNode


def display(self: Any, node: nodes.math_block) -> None:
    """A formula of its own."""
    formula = mathml(node.astext(), display="block")
    self.body.append(f'<div class="formula">{formula}</div>')
    raise nodes.SkipNode


def mathml(formula: str, **options: str) -> str:
    """MathML of a formula in LaTeX."""
    return CLOSE.sub(
        r'<mo stretchy="false" lspace="0" rspace="0">\1</mo>', convert(formula, **options)
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer under the name "mathml"."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
