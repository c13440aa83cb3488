"""Times numpy and scikit-learn with libcatamaran_blas.so loaded before their BLAS, and without it.

    python race.py LIBRARY [--sides 512,1024] [--only small|ata|gemm|complex|programs] [--repeat 7] [--csv FILE]
                   [--clock wall|cpu]

Two processes of this program take turns, so that both see the same machine; the one that waits is
stopped, with its threads. A row has the medians of both and the median of the ratios of turns; a
ratio below 1 means: faster with the library. On a machine that others use at the same time,
`--clock cpu` with OPENBLAS_NUM_THREADS=1 and CATAMARAN_NUM_THREADS=1 counts the seconds that the
processes ran.
"""

import argparse
import json
import os
import signal
import statistics
import subprocess
import sys
import time

WORKER = "--worker"


def cases(sides):
    """Names of what is timed, with groups."""
    for n in (4, 8, 16, 32, 48, 64):
        for dtype in ("float64", "float32"):
            yield "small", ("ata", n, n, dtype)
            yield "small", ("gemm", n, n, dtype)
    for n in sides:
        for dtype in ("float64", "float32"):
            yield "ata", ("ata", n, n, dtype)
    for n in sides:
        yield "ata", ("ata", 4 * n, n // 2, "float64")
    for n in sides:
        for dtype in ("float64", "float32"):
            yield "gemm", ("gemm", n, n, dtype)
    for n in sides:
        for dtype in ("complex128", "complex64"):
            for what in ("ata", "gemm", "herk"):
                yield "complex", (what, n, n, dtype)
    for n in sides:
        for what in ("ata", "gemm", "herk"):
            yield "complex", (what, 4 * n, n // 2, "complex128")
    for m, n in ((20000, 500), (5000, 2000)):
        yield "programs", ("cov", m, n, "float64")
        yield "programs", ("pca", m, n, "float64")
        yield "programs", ("cholesky", n, n, "float64")
        yield "programs", ("solve", n, n, "float64")


def prepare(what, m, n, dtype):
    """Returns a function without arguments that does the work once."""
    import numpy as np

    rng = np.random.default_rng(1)

    def matrix():
        real = rng.standard_normal((m, n))
        if dtype.startswith("complex"):
            return (real + 1j * rng.standard_normal((m, n))).astype(dtype)
        return real.astype(dtype)

    a = matrix()
    if what == "herk":
        from scipy.linalg import blas

        f = {"complex64": blas.cherk, "complex128": blas.zherk}[dtype]
        a = np.asfortranarray(a)
        out = np.zeros((n, n), dtype, order="F")
        return lambda: f(1.0, a, c=out, trans=2, overwrite_c=True)
    if what == "gemm" or dtype.startswith("complex"):
        # numpy has no conjugated operands: the copy is timed too.
        left, b = a, matrix() if what == "gemm" else a
        out = np.empty((n, n), dtype)
        return lambda: np.matmul(left.conj().T, b, out=out)
    if what == "ata":
        out = np.empty((n, n), dtype)
        return lambda: np.matmul(a.T, a, out=out)
    if what == "cov":
        return lambda: np.cov(a, rowvar=False)
    if what == "pca":
        from sklearn.decomposition import PCA

        return lambda: PCA(20, svd_solver="covariance_eigh").fit(a)
    gram = a.T @ a + n * np.eye(n, dtype=dtype)
    if what == "cholesky":
        return lambda: np.linalg.cholesky(gram)
    return lambda: np.linalg.solve(gram, a[0])


def work(clock):
    """Answers each case on standard input with the seconds of a call."""
    now = {"wall": time.perf_counter, "cpu": time.process_time}[clock]
    known = {}
    for line in sys.stdin:
        case, calls = json.loads(line)
        if tuple(case) not in known:
            known.clear()
            known[tuple(case)] = prepare(*case)
            known[tuple(case)]()
        f = known[tuple(case)]
        start = now()
        for _ in range(calls):
            f()
        print((now() - start) / calls, flush=True)


class Contender:
    """A process that times cases."""

    def __init__(self, library, clock):
        environment = {k: v for k, v in os.environ.items() if k not in ("LD_PRELOAD", "OPENBLAS_CORETYPE")}
        if library:
            environment["LD_PRELOAD"] = library
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            [sys.executable, __file__, WORKER, clock], env=environment, stdin=pipe, stdout=pipe, text=True
        )
        self.process.send_signal(signal.SIGSTOP)

    def seconds(self, case, calls=1):
        self.process.send_signal(signal.SIGCONT)
        print(json.dumps([case, calls]), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        # Threads of a BLAS stay awake for a while, and would disturb the other process.
        self.process.send_signal(signal.SIGSTOP)
        return float(answer)

    def end(self):
        self.process.kill()
        self.process.wait()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("library")
    parser.add_argument("--sides", default="512,1024,2048,4096")
    parser.add_argument("--only")
    parser.add_argument("--repeat", type=int, default=7)
    parser.add_argument("--csv")
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall")
    options = parser.parse_args()
    contenders = [
        Contender(library, options.clock) for library in (None, os.path.realpath(options.library))
    ]
    rows = [("what", "m", "n", "type", "calls", "turns", "alone_s", "with_s", "ratio")]
    for group, case in cases([int(side) for side in options.sides.split(",")]):
        if options.only and group not in options.only.split(","):
            continue
        once = contenders[0].seconds(case)
        contenders[1].seconds(case)
        calls = max(1, int(0.05 / once))
        turns = []
        for turn in range(options.repeat):
            order = (0, 1) if turn % 2 == 0 else (1, 0)
            times = {i: contenders[i].seconds(case, calls) for i in order}
            turns.append((times[0], times[1]))
        alone, ours = (statistics.median(t[i] for t in turns) for i in (0, 1))
        ratio = statistics.median(t[1] / t[0] for t in turns)
        rows.append((*case, calls, len(turns), f"{alone:.4e}", f"{ours:.4e}", f"{ratio:.3f}"))
        print("  ".join(f"{str(x):>10}" for x in rows[-1]), flush=True)
    for contender in contenders:
        contender.end()
    if options.csv:
        with open(options.csv, "w") as file:
            file.writelines(",".join(map(str, row)) + "\n" for row in rows)


if WORKER in sys.argv:
    work(sys.argv[-1])
else:
    main()
