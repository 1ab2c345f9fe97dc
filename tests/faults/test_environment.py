"""Where the code runs: read-only folders, no standard error, old libraries, pools that break."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import pytest

from dem import Scene, Settings, relax, relax_ensemble

ROOT = Path(__file__).resolve().parents[2]
RELAXED = "from dem import Scene, relax; relax(Scene(20, 1e-2), 1); print('relaxed')"


@pytest.mark.skipif(
    shutil.which("setpriv") is None or not hasattr(os, "geteuid") or os.geteuid() != 0,
    reason="needs setpriv, as root",
)
def test_numba_in_a_folder_that_cannot_be_written(tmp_path):
    """Containers, clusters: no place for Numba's cache, nor a home. It compiles anew."""
    pytest.importorskip("numba")
    for part in ("dem", "packing", "pyproject.toml"):
        copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
        copy(ROOT / part, tmp_path / part)
    for cache in tmp_path.rglob("__pycache__"):
        shutil.rmtree(cache)
    subprocess.run(["chmod", "-R", "a-w", str(tmp_path)], check=True)
    try:
        said = subprocess.run(
            [
                "setpriv", "--bounding-set=-all", "--inh-caps=-all", sys.executable, "-c", RELAXED,
            ],
            env={
                "PATH": "/usr/bin:/bin", "HOME": "/proc/none", "PYTHONDONTWRITEBYTECODE": "1",
                "PYTHONPATH": str(tmp_path),
            },
            cwd="/", capture_output=True, text=True, check=False,
        )  # fmt: skip
    finally:
        subprocess.run(["chmod", "-R", "u+w", str(tmp_path)], check=True)
    assert said.stdout.strip() == "relaxed", said.stderr


def test_the_lowest_scipy_has_what_is_imported():
    """diags_array and eye_array came with SciPy 1.12."""
    low = re.search(r'"scipy>=(\d+)\.(\d+)', (ROOT / "pyproject.toml").read_text())
    assert low is not None
    assert tuple(map(int, low.groups())) >= (1, 12)


def test_no_standard_error(monkeypatch):
    """A windowed executable has none, and no bar is shown."""
    monkeypatch.setattr(sys, "stderr", None)
    relax(Scene(20, 1e-2), 1, settings=Settings(backend="numpy"))


def test_a_pool_that_breaks_while_scenes_are_submitted(tmp_path):
    """What was ready before is stored: only what was in flight is lost."""

    class Flaky(ThreadPoolExecutor):
        def submit(self, *arguments, **more):
            made = self.__dict__.setdefault("made", [])
            if len(made) == 2:
                wait(made)
                raise RuntimeError("broken pool")
            made.append(super().submit(*arguments, **more))
            return made[-1]

    with pytest.raises(RuntimeError, match="broken pool"):
        relax_ensemble(
            [Scene(20, 1e-2)] * 4, [1, 2, 3, 4], executor=Flaky(2), store=tmp_path, progress=False
        )
    assert len(list(tmp_path.glob("*.npz"))) == 2
