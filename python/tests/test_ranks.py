"""Calls with a communicator of mpi4py, in tests/ranks.py under mpirun."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import catamaran
import numpy as np
import pytest
from scipy.sparse import csr_array

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


class One:
    """A communicator of one rank, without MPI."""

    rank, size = 0, 1

    def allgather(self, sent):
        return [sent]

    def reduce(self, sent, op, root):
        return sent


@pytest.mark.parametrize("kind", [np.int64, np.uint8, bool, np.float32])
def test_rows_of_ranks_may_be_of_any_real_numbers_and_none(kind, rng):
    a, b = rng.integers(0, 9, (30, 3)).astype(kind), rng.integers(0, 9, 30)
    found = catamaran.ata(a, comm=One(), reproducible=True)
    assert np.array_equal(found, a.T.astype(float) @ a)
    fit, right = catamaran.lstsq(a, b, comm=One()), catamaran.lstsq(a.astype(float), b)
    assert np.array_equal(fit.x, right.x)
    none = catamaran.ata(a[:0], comm=One(), reproducible=True)
    assert np.array_equal(none, np.zeros((3, 3)))


def test_rows_that_ranks_cannot_sum_are_named():
    a, bad = np.ones((4, 2)), np.array([1, 2, np.nan, 4])
    for kind, why, call in (
        (ValueError, "a: 1 entries are masked", lambda: catamaran.ata(masked(a), comm=One())),
        (ValueError, "b: 1 entries are masked", lambda: catamaran.lstsq(a, masked(a), comm=One())),
        (ValueError, "b: column 0 has an entry", lambda: catamaran.lstsq(a, bad, comm=One())),
        (TypeError, "a: sparse", lambda: catamaran.pca(csr_array(a), comm=One())),
        (TypeError, "dtype: ", lambda: catamaran.ata(a, dtype=np.float32, comm=One())),
        (TypeError, "comm: expected a communicator", lambda: catamaran.ata(a, comm=sys)),
        (TypeError, "comm: expected a communicator", lambda: catamaran.lstsq(a, a, comm=2)),
    ):
        with pytest.raises(kind, match="^" + why):
            call()


def test_a_scheme_that_is_not_reproducible_is_refused_as_in_one_process():
    a, said = np.ones((4, 2)), []
    for more in ({}, {"comm": One()}):
        with pytest.raises(ValueError) as refused:
            catamaran.ata(a, reproducible=True, scheme="winograd", **more)
        said.append(str(refused.value))
    assert said == ["scheme: only the exact scheme is reproducible on every machine"] * 2
    for scheme in ("auto", "exact"):
        found = catamaran.ata(a, reproducible=True, scheme=scheme, comm=One())
        assert np.array_equal(found, np.full((2, 2), 4.0))
    # Without `reproducible` the scheme is that of the products.
    assert np.allclose(catamaran.ata(a, scheme="winograd", comm=One()), 4.0)


def masked(a):
    return np.ma.masked_array(a, np.arange(a.size).reshape(a.shape) == 0)
