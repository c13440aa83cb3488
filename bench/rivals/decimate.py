"""One decimation of a mesh by another library.

    decimate.py METHOD INPUT.ply N OUTPUT.ply     prints seconds and bytes of the call alone; reading is not counted

METHOD: pyacvd, fast-simplification, meshoptimizer, qslim, igl-decimate (both libigl) or pymeshlab. N is the number of
vertices for pyacvd, of faces for all others.
"""

import os
import resource
import sys
import time
import warnings

import numpy as np


def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


# libigl's qslim grows without end at some meshes, such as lionstatue32k, until the system kills something. A quarter
# of the memory, and ten minutes, are more than anyone needs for the meshes of the sets.
resource.setrlimit(resource.RLIMIT_DATA, (os.sysconf("SC_PHYS_PAGES") * resource.getpagesize() // 4,) * 2)
resource.setrlimit(resource.RLIMIT_CPU, (600, 600))

method, source, n, target = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]

if method == "pymeshlab":
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(source)

    def call():
        meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=n, preservetopology=True)

    def result():
        mesh = meshes.current_mesh()
        return mesh.vertex_matrix(), mesh.face_matrix()

else:
    import pyvista

    mesh = pyvista.read(source)
    points = np.asarray(mesh.points, dtype=np.float64)
    faces = mesh.faces.reshape(-1, 4)[:, 1:].astype(np.int32)
    if method == "pyacvd":
        import pyacvd

        # It reads an attribute of meshes that pyvista says is deprecated.
        warnings.filterwarnings("ignore", module="pyacvd")

        # It joins vertices of the input, so that there must be many for each of the result. Its own example divides 2,903
        # vertices three times for 20,000 clusters, which makes 9 of each. Beside no division at all this improves the
        # vase at n = 2000 from a mean quality of 0.60 to 0.75, and the connecting rod's Hausdorff distance from 0.12 to
        # 0.05, for about a third more time.
        VERTICES_PER_CLUSTER = 10

        def call():
            clustering = pyacvd.Clustering(mesh)
            while clustering.mesh.n_points < VERTICES_PER_CLUSTER * n:
                clustering.subdivide(1)
            clustering.cluster(n)
            return clustering.create_mesh()

        def result():
            return made.points, made.faces.reshape(-1, 4)[:, 1:]

    elif method == "fast-simplification":
        import fast_simplification

        points = points.astype(np.float32)

        def call():
            return fast_simplification.simplify(points, faces, target_count=n)

        def result():
            return made[0], made[1]

    elif method == "meshoptimizer":
        import meshoptimizer

        REGULARIZE = 1 << 4  # meshopt_SimplifyRegularize
        points, corners = points.astype(np.float32), faces.astype(np.uint32).ravel()

        def call():
            kept = np.empty_like(corners)
            count = meshoptimizer.simplify(
                kept, corners, points, target_index_count=3 * n, target_error=1.0, options=REGULARIZE
            )
            return kept[:count]

        def result():
            used, corners = np.unique(made, return_inverse=True)
            return points[used], corners.reshape(-1, 3)

    else:
        import igl

        collapse = {"qslim": igl.qslim, "igl-decimate": igl.decimate}[method]
        points, faces = np.asfortranarray(points), np.asfortranarray(faces)

        def call():
            return collapse(points, faces, n)

        def result():
            return made[0], made[1]


before = resident()
start = time.perf_counter()
made = call()
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before

vertices, triangles = (np.asarray(x) for x in result())
if len(triangles) == 0:
    # libigl's collapses return nothing for meshes that are not manifolds.
    sys.exit(f"{method}: no result")
with open(target, "wb") as file:
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    file.write(header.encode())
    file.write(np.ascontiguousarray(vertices, dtype="<f8").tobytes())
    rows = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, triangles
    file.write(rows.tobytes())
print(seconds, peak)
