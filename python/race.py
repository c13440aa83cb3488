"""Times chapters of the package beside what Python has for them: pyacvd, scipy, numpy's own BLAS.

    python race.py [--repeat 5] [--csv FILE]

Needs catamaran, numpy, scipy and pyacvd (pip install pyacvd pyvista). Each contender is a process; they
take turns, and the one that waits is stopped, as threads of a BLAS stay awake after a call. A row has
the medians of both and the median of the ratios of turns, below 1 where ours is faster. `call` is a product so small that what is timed is the way from Python to the library and back.
"""

import argparse
import ctypes
import multiprocessing
import os
import signal
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
    stiffness, mass, _ = catamaran.laplacian(v, f)

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


def work(number, pipe):
    """Answers each case, with a number of calls, with the seconds of a call."""
    known, contender = None, None
    while True:
        what, calls = pipe.recv()
        if what != known:
            known, contender = what, CASES[what]()[number]
            contender()
        start = time.perf_counter()
        for _ in range(calls):
            contender()
        pipe.send((time.perf_counter() - start) / calls)


class Contender:
    """A process that times one side of the cases."""

    def __init__(self, number):
        self.pipe, end = multiprocessing.Pipe()
        self.process = multiprocessing.Process(target=work, args=(number, end), daemon=True)
        self.process.start()

    def seconds(self, what, calls=1):
        os.kill(self.process.pid, signal.SIGCONT)
        self.pipe.send((what, calls))
        answer = self.pipe.recv()
        os.kill(self.process.pid, signal.SIGSTOP)
        return answer

    def end(self):
        self.process.kill()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--csv")
    options = parser.parse_args()
    rows = [("what", "turns", "ours_s", "theirs_s", "ratio")]
    contenders = [Contender(0), Contender(1)]
    for what in CASES:
        calls = max(1, int(0.02 / max(contender.seconds(what) for contender in contenders)))
        turns = [[c.seconds(what, calls) for c in contenders] for _ in range(options.repeat)]
        ours, theirs = (statistics.median(turn[i] for turn in turns) for i in (0, 1))
        ratio = statistics.median(turn[0] / turn[1] for turn in turns)
        rows.append((what, options.repeat, f"{ours:.4e}", f"{theirs:.4e}", f"{ratio:.3f}"))
        print("  ".join(f"{str(x):>26}" for x in rows[-1]), flush=True)
    for contender in contenders:
        contender.end()
    if options.csv:
        with open(options.csv, "w", encoding="utf-8") as file:
            file.writelines(",".join(map(str, row)) + "\n" for row in rows)


if __name__ == "__main__":
    multiprocessing.set_start_method("spawn")
    main()
