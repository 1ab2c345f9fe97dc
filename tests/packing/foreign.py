"""The folder of packings from elsewhere: that of PACKING_DATA, or ../shared/data, or a skip."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def foreign(*names: str) -> Path:
    """A file or folder; skip by name where it is not, fail where the folder named is not."""
    told = os.environ.get("PACKING_DATA")
    if told and not Path(told).is_dir():
        pytest.fail(f"PACKING_DATA = {told}: no such folder")
    path = Path(told or ROOT.parent / "shared" / "data", *names)
    if not path.exists():
        pytest.skip(f"{'/'.join(names)} is in neither PACKING_DATA nor ../shared/data")
    return path
