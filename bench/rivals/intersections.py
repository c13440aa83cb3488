"""Faces that intersect other faces of their mesh, by the exact predicates of CGAL in libigl.

    intersections.py MESH.ply ...     prints their numbers, in the order of the meshes

pymeshlab reads the meshes: libigl refuses some PLY files, and VTK rounds positions to 32 bits.
"""

import sys

import numpy as np
import pymeshlab
from igl.copyleft import cgal


def count(path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(path)
    mesh = meshes.current_mesh()
    vertices = np.ascontiguousarray(mesh.vertex_matrix(), dtype=np.float64)
    faces = np.ascontiguousarray(mesh.face_matrix(), dtype=np.int64)
    pairs = cgal.remesh_self_intersections(vertices, faces, detect_only=True)[2]
    return len(np.unique(pairs))


print(*(count(path) for path in sys.argv[1:]))
