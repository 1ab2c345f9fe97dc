"""The version of this code, installed or not.

A checkout is what its own ``pyproject.toml`` says, whatever else is installed; elsewhere the
metadata of the installation say it.  Where neither is at hand (a folder copied by itself) the
version is "unknown".
"""

from __future__ import annotations

import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

NAME = "packing-forces"


def version_of(folder: Path) -> str:
    """The version of the code whose packages lie in ``folder``."""
    try:
        project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        if project["name"] == NAME:
            return str(project["version"])
    except (OSError, ValueError, KeyError, TypeError):
        pass  # no checkout of this project
    try:
        return version(NAME)
    except PackageNotFoundError:
        return "unknown"


__version__ = version_of(Path(__file__).resolve().parent.parent)
