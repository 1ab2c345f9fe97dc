"""The README's lines of Python, run where this file is started: python -P readme_lines.py"""

from __future__ import annotations

import re
from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"


def lines() -> str:
    """The first block of Python in the README."""
    found = re.search(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    if found is None:
        raise ValueError("the README has no lines of Python")
    return found.group(1)


if __name__ == "__main__":
    exec(compile(lines(), "README.md", "exec"), {})
