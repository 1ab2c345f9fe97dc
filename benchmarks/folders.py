"""Where tables and figures go: quick ones to the build folder, full ones beside the code."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
QUICK, FULL = ROOT / "build" / "benchmarks", ROOT / "benchmarks" / "results"
