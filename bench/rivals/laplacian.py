"""One tufted Laplacian by robust_laplacian (Sharp and Crane 2020).

    laplacian.py FOLDER     reads vertices and faces of FOLDER, .npy each; prints seconds, bytes, the sum of M and the
                            energies x^T W x of the three coordinates
"""

import resource
import sys
import time

import numpy as np
import robust_laplacian


def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


folder = sys.argv[1]
vertices = np.ascontiguousarray(np.load(f"{folder}/vertices.npy"))
faces = np.load(f"{folder}/faces.npy").astype(np.int64)

before = resident()
start = time.perf_counter()
W, M = robust_laplacian.mesh_laplacian(vertices, faces)
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before

energies = (vertices * (W @ vertices)).sum(axis=0)
print(seconds, peak, M.sum(), *energies)
