"""One functional map by pyfmaps: the fit to descriptors, and ZoomOut.

    functional_map.py FOLDER K STEP     reads vertices_S, faces_S, values_S, functions_S, mass_S and descriptors_S of FOLDER
                                        for S = source and target, .npy each; fits K x K and zooms out by STEP to all
                                        functions; writes points.npy there and prints seconds, bytes, and the seconds
                                        of the fit
"""

import resource
import sys
import time

import numpy as np
import scipy.sparse as sparse
from pyFM.functional import FunctionalMapping
from pyFM.mesh import TriMesh
from pyFM.refine.zoomout import zoomout_refine


def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


folder, k, step = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
meshes, descriptors = [], []
for side in ("source", "target"):
    get = lambda name: np.ascontiguousarray(np.load(f"{folder}/{name}_{side}.npy"))
    mesh = TriMesh(get("vertices"), get("faces").astype(np.int64))
    mesh.mass = sparse.diags(get("mass").ravel()).tocsc()
    mesh.eigenvalues, mesh.eigenvectors = get("values").ravel(), get("functions")
    meshes.append(mesh)
    descriptors.append(get("descriptors"))

before = resident()
start = time.perf_counter()
model = FunctionalMapping(*meshes)
model.add_descriptors(*descriptors)
model.fit(K=(k, k), w_descr=1, w_lap=1e-3, w_dcomm=0, use_resolvent_laplacian=False, factr=10, pgtol=1e-12)
fitted = time.perf_counter() - start
evects = [mesh.eigenvectors for mesh in meshes]
steps = (evects[0].shape[1] - k) // step
_, points = zoomout_refine(
    model.FM_12, *evects, nit=steps, step=step, A2=meshes[1].mass, return_p2p=True
)
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before

np.save(f"{folder}/points.npy", points.astype(float))
print(seconds, peak, fitted)
