"""One orthogonalization of the columns of a matrix, in the inner product of a diagonal mass.

    gram_schmidt.py FOLDER METHOD     reads a (c x n: by columns) and mass of FOLDER, .npy each; METHOD is columns (numpy,
                                      column by column, twice) or dgeqp3 (LAPACK, pivoted QR of sqrt(M) A, with Q);
                                      prints seconds, bytes, rank and the largest entry of |Q^T M Q - I|
"""

import sys
import time

import numpy as np
from scipy.linalg import qr


def memory(key):
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) << 10 for line in status if line.startswith(key))


def columns(a, mass, threshold=1e-9):
    """Gram-Schmidt as it is usually written in numpy, with re-orthogonalization."""
    q = np.empty_like(a, order="F")
    rank = 0
    for j in range(a.shape[1]):
        x = a[:, j].copy()
        norm = np.sqrt(x @ (mass * x))
        for _ in range(2):
            basis = q[:, :rank]
            x -= basis @ (basis.T @ (mass * x))
        left = np.sqrt(x @ (mass * x))
        if left > threshold * norm:
            q[:, rank] = x / left
            rank += 1
    return q[:, :rank]


def dgeqp3(a, mass, threshold=1e-9):
    root = np.sqrt(mass)[:, None]
    q, r, _ = qr(root * a, mode="economic", pivoting=True, overwrite_a=True, check_finite=False)
    diagonal = np.abs(np.diag(r))
    rank = int(np.count_nonzero(diagonal > threshold * diagonal[0]))
    return q[:, :rank] / root


folder, method = sys.argv[1:3]
a = np.load(f"{folder}/a.npy").T
mass = np.load(f"{folder}/mass.npy").ravel()

# The peak of what follows, not of reading.
with open("/proc/self/clear_refs", "w") as peak:
    peak.write("5")
before = memory("VmRSS:")
start = time.perf_counter()
q = {"columns": columns, "dgeqp3": dgeqp3}[method](a, mass)
seconds = time.perf_counter() - start
peak = memory("VmHWM:") - before
gram = q.T @ (mass[:, None] * q)
print(seconds, peak, q.shape[1], np.abs(gram - np.eye(q.shape[1])).max())
