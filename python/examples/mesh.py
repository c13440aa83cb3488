"""From a mesh file to spectra, distances and fewer vertices, as in c_examples/mesh.cpp.

mesh.py [PICTURE [MESH]]
"""

import sys

import numpy as np
from _picture import draw, panels, save

import catamaran

if len(sys.argv) > 2:
    v, f = catamaran.read_mesh(sys.argv[2])
else:  # A torus whose triangles share no vertex.
    k, turn = np.arange(60 * 30 * 2)[:, None], np.exp(1j * np.pi / 30 * np.arange(60))
    u = turn[(k // 2 + np.where(k % 2, [0, 1, 0], [0, 1, 1])) % 60]
    w = turn[2 * ((k // 120 + np.where(k % 2, [0, 1, 1], [0, 0, 1])) % 30)]
    v = np.stack([(2 + w.real) * u.real, (2 + w.real) * u.imag, w.imag], 2).reshape(-1, 3)
    f = np.arange(len(v)).reshape(-1, 3)

repaired = catamaran.repair(v, f, everything=True, fill_holes=30)
print(*repaired.report, sep="\n")
mesh = repaired.mesh
values, vectors = catamaran.eigsh(mesh, 50)
distances = catamaran.distances(mesh, [mesh.f[0, 0]])
small = catamaran.decimate(mesh, len(mesh.v) // 4)
kept = f"{len(mesh.v)} vertices, {len(small.v)} of them kept"
print(f"{kept}; the last of 50 eigenvalues is {values[-1]:.6g}")

figure, axes = panels(3)
draw(axes[0], *mesh, vectors[:, 9], cmap="RdBu_r", title="an eigenfunction")
draw(axes[1], *mesh, distances, title="distances from a vertex")
draw(axes[2], small.v, small.f, lines=True, title=f"{len(small.v)} vertices")
save(figure, __file__)
