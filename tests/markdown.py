"""Pages of Markdown: their Python is run, and what it prints is compared with what they say.

print(x)  # 0.3: and why         says that "0.3" is printed, a number to ten per cent
"""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
SAID = re.compile(r"^print\(.*\)  # (.*?)(?:: .*|, what .*)?$", re.MULTILINE)
LINK = re.compile(r"\]\(([^()\s]+)\)")


def blocks(page: Path) -> list[str]:
    """The blocks of Python of a page."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


def run(page: Path) -> dict[str, Any]:
    """Run all blocks in order, compare what is printed, and return the names."""
    names: dict[str, Any] = {"__name__": page.stem}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for block in blocks(page):
            exec(compile(block, str(page), "exec", dont_inherit=True), names)
    said = [text for block in blocks(page) for text in SAID.findall(block)]
    found = printed.getvalue().splitlines()
    assert len(said) == len(found), f"{page.name} says {said} and prints {found}"
    for expected, line in zip(said, found, strict=True):
        try:
            number = float(expected)
        except ValueError:
            assert line == expected, page.name
        else:
            assert float(line) == pytest.approx(number, rel=0.1), page.name
    return names


def links(page: Path) -> list[str]:
    """Targets of links into the repository, without their anchors."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    found = (target.partition("#")[0] for target in LINK.findall(text))
    return [target for target in found if target and "://" not in target]
