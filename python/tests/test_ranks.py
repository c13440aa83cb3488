"""Calls with a communicator of mpi4py, in tests/ranks.py under mpirun."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("ranks.py")
# In a container one is root, and has fewer cores than ranks.
OPEN_MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}


@pytest.mark.parametrize("work", ["products", "applications", "errors", "eigenpairs"])
@pytest.mark.parametrize("ranks", ["2", "3"])
def test_ranks_of_mpi4py_agree_with_one_process(work, ranks):
    pytest.importorskip("mpi4py")
    mpirun = shutil.which("mpirun")
    if mpirun is None:
        pytest.skip("mpirun is missing")
    command = [mpirun, "-n", ranks, sys.executable, PROGRAM, work]
    environment = {**os.environ, **OPEN_MPI, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert f"{ranks} ranks agree" in done.stdout
