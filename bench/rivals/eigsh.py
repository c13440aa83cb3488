"""One solution of W phi = lambda M phi by scipy's eigsh (ARPACK, shift-invert by SuperLU).

    eigsh.py FOLDER K     reads data, indices, indptr (W by rows) and mass (M, a diagonal) of FOLDER, .npy each;
                          writes values.npy and residuals.npy there and prints seconds and bytes
"""

import resource
import sys
import time

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh


def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


folder, k = sys.argv[1], int(sys.argv[2])
data, indices, indptr, mass = (
    np.load(f"{folder}/{name}.npy").ravel() for name in ("data", "indices", "indptr", "mass")
)
n = len(mass)
W = sparse.csr_matrix((data, indices.astype(np.int32), indptr.astype(np.int32)), shape=(n, n)).tocsc()
M = sparse.diags(mass).tocsc()

before = resident()
start = time.perf_counter()
values, vectors = eigsh(W, k, M, sigma=-0.01)
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before

order = np.argsort(values)
values, vectors = values[order], vectors[:, order]
images = W @ vectors
differences = np.linalg.norm(images - (M @ vectors) * values, axis=0)
np.save(f"{folder}/values.npy", values)
np.save(f"{folder}/residuals.npy", differences / np.maximum(np.linalg.norm(images, axis=0), 1e-300))
print(seconds, peak)
