"""Colours told apart by the colour-blind too (Okabe and Ito), and those of the estimators."""

from __future__ import annotations

PALETTE = (
    "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#999999", "#000000",
)  # fmt: skip
COLOURS = {
    "gppsz": "#D55E00", "balanced": "#E69F00", "direct": "#999999",
    "optimal": "#0072B2", "bounded": "#009E73",
}  # fmt: skip
"""Of the estimators, in every figure."""
