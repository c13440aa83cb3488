"""A program that mpirun starts for test_ranks.py: calls with the communicator of mpi4py, beside
those of one process."""

import sys

import numpy as np
from mpi4py import MPI

import catamaran

comm = MPI.COMM_WORLD
rng = np.random.default_rng(5)
a = rng.standard_normal((900, 7)) * 10.0 ** np.arange(7)
b = a @ np.ones((7, 2)) + rng.standard_normal((900, 2))
w = rng.uniform(0, 3, 900)
# Unequal shares, the last one empty unless it is the only one.
cuts = np.array([0, 500, 700, 900] + [900] * comm.size)[: comm.size + 1]
cuts[-1] = 900
own = slice(cuts[comm.rank], cuts[comm.rank + 1])


def same(found, expected):
    """Every rank has the bytes of one process."""
    for name in vars(expected) if hasattr(expected, "__dict__") else []:
        if not name.startswith("_"):
            one, other = getattr(found, name), getattr(expected, name)
            assert np.array_equal(one, other, equal_nan=True), name


def raised(kind, call):
    """Returns the message of the error that every rank raises."""
    try:
        call()
    except kind as error:
        return str(error)
    raise AssertionError("no error")


def products():
    for options in ({}, {"center": True}, {"weights": w}, {"uplo": "lower", "alpha": 2.0}):
        mine = {k: v[own] if k == "weights" else v for k, v in options.items()}
        expected = catamaran.ata(a, **options)
        found = catamaran.ata(a[own], comm=comm, **mine)
        assert np.allclose(found, expected, rtol=1e-12, atol=1e-9)
        exact = catamaran.ata(a[own], comm=comm, reproducible=True, **mine)
        one = catamaran.ata(a, comm=MPI.COMM_SELF, reproducible=True, **options)
        assert np.array_equal(exact, one)
    narrow = catamaran.ata(a[own].astype(np.float32), comm=comm)
    assert narrow.dtype == np.float32
    wide = catamaran.ata(a[own].astype(np.float32), comm=comm, dtype=np.float64)
    assert wide.dtype == np.float64


def applications():
    for weights in (None, w):
        mine = None if weights is None else weights[own]
        for intercept in (False, True):
            expected = catamaran.lstsq(a, b, weights=weights, intercept=intercept)
            more = {"weights": mine, "intercept": intercept, "comm": comm}
            same(catamaran.lstsq(a[own], b[own], **more), expected)
        expected = catamaran.pca(a, 3, weights=weights)
        same(catamaran.pca(a[own], 3, weights=mine, comm=comm), expected)
    found = catamaran.lstsq(a[own], b[own, 0], comm=comm)
    same(found, catamaran.lstsq(a, b[:, 0]))
    assert found.x.shape == (7,)


class Labelled(list):
    """Rows with labels, as far as their comparison."""

    iloc = None
    index = property(lambda self: self)

    def equals(self, other):
        return self == other


def errors():
    last = comm.size - 1
    wrong = a[own, :6] if comm.rank == last else a[own]
    said = raised(ValueError, lambda: catamaran.ata(wrong, comm=comm))
    assert said == f"rank {last}: columns: 6, where rank 0 has 7", said
    bad = np.full((1, 7), np.nan) if comm.rank == last else a[own]
    kind = ValueError if comm.rank == last else RuntimeError
    said = raised(kind, lambda: catamaran.pca(bad, comm=comm))
    assert said.endswith("a: column 0 has an entry that is not finite"), said
    assert comm.rank == last or said.startswith(f"rank {last}: ValueError"), said
    rows, others = (a[own], b[own, 0]) if comm.rank != last else (Labelled("ab"), Labelled("ba"))
    said = raised(kind, lambda: catamaran.lstsq(rows, others, comm=comm))
    assert "b: its index is not that of the rows" in said, said
    said = raised(ValueError, lambda: catamaran.ata(a, a, comm=comm))
    assert said.startswith("comm: "), said


def eigenpairs():
    v, f = catamaran.shapes.icosphere(3)
    stiffness, mass, _ = catamaran.laplacian(v, f)
    n = stiffness.shape[0]
    rows = slice(n * comm.rank // comm.size, n * (comm.rank + 1) // comm.size)
    try:
        found = catamaran.eigsh(stiffness[rows], mass.diagonal()[rows], 9, comm=comm)
    except NotImplementedError as error:
        assert "--features mpi" in str(error)
        return
    expected = catamaran.eigsh(stiffness, mass, 9)
    assert np.allclose(found.values, expected.values, rtol=1e-8, atol=1e-8)
    assert found.vectors.shape == (rows.stop - rows.start, 9)
    vectors = np.concatenate(comm.allgather(found.vectors))
    assert np.allclose(vectors.T @ (mass @ vectors), np.eye(9), atol=1e-8)


{"products": products, "applications": applications, "errors": errors, "eigenpairs": eigenpairs}[
    sys.argv[1]
]()
if comm.rank == 0:
    print(f"{comm.size} ranks agree")
