"""The page of the command line: what it shows is what is printed."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from packing_forces.options import VERBS

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "howto" / "command_line.md").read_text("utf-8")


def shown():
    """(words, lines that follow) of every command in the consoles of the page."""
    for block in re.findall(r"^```console\n(.*?)^```", PAGE, re.S | re.M):
        for part in block.split("$ packing-forces ")[1:]:
            command, *lines = part.splitlines()
            yield command.split(), lines


def test_consoles_show_what_is_printed(ask, tmp_path):
    """Line by line; "..." stands for lines left out."""
    for path in (ROOT / "tests" / "data" / "lammps_dump").glob("*.dump"):
        shutil.copy(path, tmp_path)
    commands = list(shown())
    assert len(commands) == 5
    for words, lines in commands:
        _, out, err = ask(*words)
        printed = (out + err).splitlines()
        if "..." not in lines:
            assert printed == lines
        for line in lines:
            assert line == "..." or line in printed, line


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_is_on_the_page(verb):
    assert f"| `{verb}` |" in PAGE
