"""One solution of W phi = lambda M phi, W positive semidefinite, M a diagonal, around the shift that ours takes: by
the first eigenvalue of a plane of that area. (A fixed shift is far from the eigenvalues of a large mesh.)

    eigsh.py FOLDER K SOLVER   reads data, indices, indptr (W by rows) and mass (M) of FOLDER, .npy each; writes
                               values.npy and residuals.npy there and prints seconds and bytes

SOLVER, each with a factorization of W - shift M that is computed within the time:
    superlu   scipy's eigsh (ARPACK), its default factorization by SuperLU
    cholmod   scipy's eigsh, a factorization by CHOLMOD (scikit-sparse)
    cholespy  scipy's eigsh, a factorization by CHOLMOD as cholespy builds it
    primme    PRIMME's eigsh of M^1/2 (W - shift M)^-1 M^1/2, a factorization by CHOLMOD or cholespy
"""

import resource
import sys
import time

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import LinearOperator, eigsh

def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


def cholmod(matrix):
    from sksparse.cholmod import cholesky

    return cholesky(matrix).solve_A


def cholespy(matrix):
    from cholespy import CholeskySolverD, MatrixType

    n = matrix.shape[0]
    solver = CholeskySolverD(n, matrix.indptr, matrix.indices, matrix.data, MatrixType.CSC)

    def solve(b):
        x = np.empty(n)
        solver.solve(np.ascontiguousarray(b, dtype=np.float64).ravel(), x)
        return x

    return solve


def fastest(matrix):
    """The factorization of scikit-sparse if it is installed, else that of cholespy."""
    try:
        return cholmod(matrix)
    except ImportError:
        return cholespy(matrix)


def by_scipy(factorize):
    inverse = LinearOperator((n, n), matvec=factorize((W - shift * M).tocsc()), dtype=np.float64)
    return eigsh(W, k, M, sigma=shift, OPinv=inverse)


def by_primme():
    import primme

    solve, root = fastest((W - shift * M).tocsc()), np.sqrt(mass)

    def apply(x):
        columns = x.reshape(n, -1)
        return np.stack([root * solve(root * column) for column in columns.T], axis=1).reshape(x.shape)

    inverse = LinearOperator((n, n), matvec=apply, matmat=apply, dtype=np.float64)
    inverted, vectors = primme.eigsh(inverse, k, which="LA", tol=1e-12)
    return shift + 1 / inverted, vectors / root[:, None]


folder, k, solver = sys.argv[1], int(sys.argv[2]), sys.argv[3]
data, indices, indptr, mass = (
    np.load(f"{folder}/{name}.npy").ravel() for name in ("data", "indices", "indptr", "mass")
)
n = len(mass)
shift = -2 * np.sqrt(3) / mass.sum()
W = sparse.csr_matrix((data, indices.astype(np.int32), indptr.astype(np.int32)), shape=(n, n)).tocsc()
M = sparse.diags(mass).tocsc()
solvers = {
    "superlu": lambda: eigsh(W, k, M, sigma=shift),
    "cholmod": lambda: by_scipy(cholmod),
    "cholespy": lambda: by_scipy(cholespy),
    "primme": by_primme,
}

before = resident()
start = time.perf_counter()
values, vectors = solvers[solver]()
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before

order = np.argsort(values)
values, vectors = values[order], vectors[:, order]
images = W @ vectors
differences = np.linalg.norm(images - (M @ vectors) * values, axis=0)
np.save(f"{folder}/values.npy", values)
np.save(f"{folder}/residuals.npy", differences / np.maximum(np.linalg.norm(images, axis=0), 1e-300))
print(seconds, peak)
