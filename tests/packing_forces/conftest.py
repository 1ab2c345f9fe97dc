"""Files to ask the command line about: a packing, and the same as dumps of six digits."""

from __future__ import annotations

import json

import pytest

from packing_forces.command_line import main
from tests.conftest import packing
from tests.packing_forces.dumps import write_dumps


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with packing.npz, atoms.dump and contacts.dump of 80 grains at Δ = 3e-5."""
    folder = tmp_path_factory.mktemp("files")
    made = packing(grains=80, delta=3e-5, seed=3)
    made.save(folder / "packing.npz")
    write_dumps(made, folder)
    return folder


@pytest.fixture
def ask(capsys, monkeypatch, tmp_path):
    """ask(words...) -> (exit code, output or its JSON, errors), in a new folder."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        try:
            code = main([str(word) for word in words])
        except SystemExit as left:
            code = left.code
        said = capsys.readouterr()
        out = json.loads(said.out) if "--json" in words and said.out else said.out
        return code, out, said.err

    return run
