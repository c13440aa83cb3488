"""Times chapters of the package beside what Python has for them: pyacvd, scipy, numpy's own BLAS.

    python race.py [--repeat 5] [--csv FILE]

Needs catamaran, numpy, scipy and pyacvd (pip install pyacvd pyvista). Contenders take turns in one
process; a row has the medians of both and the median of the ratios of turns, below 1 where ours is
faster. `call` is a product so small that what is timed is the way from Python to the library and back.
"""

import argparse
import ctypes
import statistics
import time

import numpy as np
import scipy.sparse.linalg

import catamaran


def decimation(side, n):
    """A torus of `side` x side / 2 vertices to n vertices."""
    import pyacvd
    import pyvista

    v, f = catamaran.shapes.torus(side, side // 2)
    faces = np.hstack([np.full((len(f), 1), 3), f]).ravel()
    surface = pyvista.PolyData(v, faces)

    def theirs():
        clustering = pyacvd.Clustering(surface)
        clustering.cluster(n)
        clustering.create_mesh()

    return lambda: catamaran.decimate(v, f, n), theirs


def eigenpairs(side, k):
    """The k smallest eigenpairs of a torus."""
    v, f = catamaran.shapes.torus(side, side // 2)
    stiffness, mass = catamaran.laplacian(v, f)

    def theirs():
        scipy.sparse.linalg.eigsh(stiffness.tocsc(), k, mass.tocsc(), sigma=-1e-2, which="LM")

    return lambda: catamaran.eigsh(v, f, k), theirs


def product(m, n):
    a = np.random.default_rng(1).standard_normal((m, n))
    return lambda: catamaran.ata(a), lambda: a.T @ a


def call():
    """Beside a call of libc by ctypes, which is about what a call costs in Python."""
    a = np.ones((2, 2))
    nothing = ctypes.CDLL(None).abs
    return lambda: catamaran.ata(a), lambda: nothing(1)


CASES = {
    "decimate 20000 to 1000": lambda: decimation(200, 1000),
    "decimate 80000 to 5000": lambda: decimation(400, 5000),
    "eigsh of 20000": lambda: eigenpairs(200, 50),
    "ata 20000 x 500": lambda: product(20000, 500),
    "call": call,
}


def seconds(work, calls):
    start = time.perf_counter()
    for _ in range(calls):
        work()
    return (time.perf_counter() - start) / calls


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--csv")
    options = parser.parse_args()
    rows = [("what", "turns", "ours_s", "theirs_s", "ratio")]
    for what, make in CASES.items():
        contenders = make()
        calls = max(1, int(0.02 / max(seconds(work, 1) for work in contenders)))
        turns = [[seconds(work, calls) for work in contenders] for _ in range(options.repeat)]
        ours, theirs = (statistics.median(turn[i] for turn in turns) for i in (0, 1))
        ratio = statistics.median(turn[0] / turn[1] for turn in turns)
        rows.append((what, options.repeat, f"{ours:.4e}", f"{theirs:.4e}", f"{ratio:.3f}"))
        print("  ".join(f"{str(x):>26}" for x in rows[-1]), flush=True)
    if options.csv:
        with open(options.csv, "w", encoding="utf-8") as file:
            file.writelines(",".join(map(str, row)) + "\n" for row in rows)


main()
