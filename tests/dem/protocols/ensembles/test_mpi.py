"""The executor of mpi4py: an ensemble on processes that MPI started."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from dem import Scene, Settings, packing_key, relax
from dem.protocols.ensembles.store import Store

ROOT = Path(__file__).resolve().parents[4]
MPIEXEC = Path(sys.prefix) / "bin" / "mpiexec"
RUN = """
import sys
from mpi4py.futures import MPIPoolExecutor
from dem import Scene, Settings, relax_ensemble

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        relax_ensemble(
            [Scene(20, 1e-1)] * 3, range(3), executor=executor, store=sys.argv[1],
            settings=Settings(backend="numpy"), progress=False,
        )
        print("ranks that worked:", executor.num_workers)
"""


@pytest.mark.skipif(
    find_spec("mpi4py") is None or not MPIEXEC.exists(), reason="mpi4py or mpiexec is missing"
)
def test_an_ensemble_runs_on_the_ranks_of_mpi(tmp_path):
    script, store = tmp_path / "run.py", tmp_path / "store"
    script.write_text(RUN)
    environment = os.environ | {
        "LD_LIBRARY_PATH": str(Path(sys.prefix) / "lib"), "PYTHONPATH": str(ROOT),
    }  # fmt: skip
    line = [MPIEXEC, "-n", "3", sys.executable, "-m", "mpi4py.futures", script, store]
    done = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=240)
    assert "ranks that worked: 2" in done.stdout, done.stderr
    settings = Settings(backend="numpy")
    scene, kept = Scene(20, 1e-1), Store.at(store)
    for seed in range(3):
        stored = kept.get(packing_key(scene, seed, settings), scene, seed)
        made = relax(scene, seed, settings=settings, progress=False)
        assert np.array_equal(stored.normal_forces, made.normal_forces)
