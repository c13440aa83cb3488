"""The water of a plant by other libraries.

    plant.py FOLDER RIVAL     reads parents, full, exchanges, losses and seconds of FOLDER, .npy each; writes theirs.npy,
                              the water after so many seconds from full cells, and prints: seconds of that, bytes,
                              seconds of a factorization, seconds of a step of BDF6 (nan where there is none)

Rivals: splu (scipy's SuperLU), klu (SuiteSparse, through ctypes), expm_multiply and bdf (scipy), cvode (SUNDIALS, by
scikit-sundae, with its sparse direct solver).
"""

import ctypes
import glob
import resource
import sys
import time

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import expm_multiply, splu

STEPS = 16
TIMED = 20
WEIGHTS = np.array([-10, 72, -225, 400, -450, 360]) / 147
TOLERANCE = 1e-8


class Klu:
    """klu_factor and klu_solve of a square matrix by columns."""

    def __init__(self, matrix):
        library = glob.glob(sys.prefix + "/usr/lib/*/libklu.so*") + ["libklu.so"]
        for name in ("suitesparseconfig", "amd", "colamd", "btf"):
            for path in sorted(glob.glob(f"{sys.prefix}/usr/lib/*/lib{name}.so*"))[:1]:
                ctypes.CDLL(path, ctypes.RTLD_GLOBAL)
        self.klu = ctypes.CDLL(sorted(library)[0], ctypes.RTLD_GLOBAL)
        for function in ("klu_analyze", "klu_factor"):
            getattr(self.klu, function).restype = ctypes.c_void_p
        self.common = ctypes.create_string_buffer(1024)  # klu_common is about 200 bytes
        self.klu.klu_defaults(self.common)
        self.n = matrix.shape[0]
        self.matrix = matrix
        pointer = lambda array, kind: array.ctypes.data_as(ctypes.POINTER(kind))
        self.p, self.i = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)
        p, i = pointer(self.p, ctypes.c_int), pointer(self.i, ctypes.c_int)
        x = pointer(matrix.data, ctypes.c_double)
        self.symbolic = ctypes.c_void_p(self.klu.klu_analyze(self.n, p, i, self.common))
        start = time.perf_counter()
        self.numeric = ctypes.c_void_p(self.klu.klu_factor(p, i, x, self.symbolic, self.common))
        self.seconds = time.perf_counter() - start

    def solve(self, right):
        b = np.array(right)
        place = b.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self.klu.klu_solve(self.symbolic, self.numeric, self.n, 1, place, self.common)
        return b


def radau_start(S, theta, dt):
    """Five steps of Radau IIA of order 5 by its partial fractions."""
    identity = sparse.identity(S.shape[0], format="csc", dtype=complex)
    q = np.array([-1 / 60, 3 / 20, -3 / 5, 1.0])
    poles = np.roots(q)
    residues = np.polyval([1 / 20, 2 / 5, 1.0], poles) / np.polyval(np.polyder(q), poles)
    factors = [splu((dt * S - z * identity).tocsc()) for z in poles]
    history = [theta]
    for _ in range(5):
        x = history[-1].astype(complex)
        history.append(sum(c * f.solve(x) for c, f in zip(residues, factors)).real)
    return history


folder, rival = sys.argv[1:3]
parents, full, exchanges, losses, seconds = (
    np.load(f"{folder}/{name}.npy").ravel()
    for name in ("parents", "full", "exchanges", "losses", "seconds")
)
n, seconds = len(full), seconds[0]
child = np.flatnonzero(parents >= 0)
parent, w = parents[child].astype(int), exchanges[child]
L = sparse.coo_matrix((-np.r_[w, w], (np.r_[child, parent], np.r_[parent, child])), shape=(n, n)).tocsr()
L -= sparse.diags(np.asarray(L.sum(1)).ravel())
S = (-(L @ sparse.diags(1 / full)) - sparse.diags(losses)).tocsc()
dt = seconds / STEPS
factor_seconds = step_seconds = float("nan")

if rival in ("splu", "klu"):
    A = (sparse.identity(n, format="csc") - 60 / 147 * dt * S).tocsc()
    A.sort_indices()
    start = time.perf_counter()
    solver = splu(A) if rival == "splu" else Klu(A)
    factor_seconds = time.perf_counter() - start if rival == "splu" else solver.seconds
    history = radau_start(S, full, dt)
    start = time.perf_counter()
    for _ in range(STEPS - 5):
        right = sum(weight * x for weight, x in zip(WEIGHTS, history))
        history = history[1:] + [solver.solve(right)]
    result_seconds = factor_seconds + time.perf_counter() - start
    result = history[-1]
    start = time.perf_counter()
    for _ in range(TIMED):
        right = sum(weight * x for weight, x in zip(WEIGHTS, history))
        history = history[1:] + [solver.solve(right)]
    step_seconds = (time.perf_counter() - start) / TIMED
elif rival == "expm_multiply":
    norm = abs(S).sum(0).max() * seconds
    if norm > 1e6:
        sys.exit(f"expm_multiply: the norm of S t is {norm:.0e}, and it takes as many products")
    start = time.perf_counter()
    result = expm_multiply(S * seconds, full)
    result_seconds = time.perf_counter() - start
elif rival == "bdf":
    from scipy.integrate import solve_ivp

    start = time.perf_counter()
    solution = solve_ivp(
        lambda _, x: S @ x, (0, seconds), full, "BDF", jac=S, t_eval=[seconds], rtol=TOLERANCE, atol=TOLERANCE * full.max()
    )
    result_seconds = time.perf_counter() - start
    result = solution.y[:, -1]
elif rival == "cvode":
    from sksundae.cvode import CVODE

    def right_side(_, x, rate):
        rate[:] = S @ x

    def jacobian(_, x, rate, out):
        out.data[:] = S.data

    start = time.perf_counter()
    solver = CVODE(
        right_side, method="BDF", rtol=TOLERANCE, atol=TOLERANCE * full.max(), linsolver="sparse", sparsity=abs(S) > 0,
        max_num_steps=100000,
    )
    result = np.asarray(solver.solve(np.array([0.0, seconds]), full).y)[-1]
    result_seconds = time.perf_counter() - start
else:
    sys.exit(f"{rival}: unknown")

np.save(f"{folder}/theirs.npy", result)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
print(result_seconds, peak, factor_seconds, step_seconds)
