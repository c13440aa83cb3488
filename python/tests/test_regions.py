"""Curves drawn into meshes, points as vertices, cuts and regions."""

import numpy as np
import pytest

import catamaran
from catamaran import shapes

GRID = shapes.grid(8, 8)
LARGE, SMALL = [10, 64, 16, 70], [20, 60, 56, 24]  # corners of 6 x 6 and of 4 x 4 squares


def area(mesh, mask):
    return mesh.face_areas[mask].sum()


def test_curves_become_edges_of_a_finer_mesh():
    samples = [10, 25, 64]
    (curve,) = catamaran.curve(GRID, samples, smooth=True).curves
    found = catamaran.draw(GRID, [(samples, {})], smooth=True)
    mesh, faces, vertices, weights = found.refined
    (drawn,) = found.layers[0].curves
    assert found.layers[0].complete and np.isclose(drawn.length, curve.length)
    assert set(map(tuple, drawn.edges)) <= set(map(tuple, mesh.edges))
    ends = mesh.v[drawn.edges]
    assert np.isclose(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum(), drawn.length)
    # The same surface, and where each vertex and face is on the grid.
    assert len(mesh.f) > len(GRID.f) and np.isclose(mesh.area, GRID.area)
    assert np.array_equal(mesh.v[: len(GRID.v)], GRID.v)
    assert np.allclose(np.einsum("ij,ijk->ik", weights, GRID.v[vertices]), mesh.v)
    assert np.allclose(found.refined.carried(GRID.v), mesh.v)
    assert np.allclose(found.refined.carried(GRID.v[:, 0]), mesh.v[:, 0])
    for few in (GRID.v[:80], 1.0):
        with pytest.raises(ValueError, match="values: expected a row for each vertex, at least 81"):
            found.refined.carried(few)
    assert np.allclose(np.bincount(faces, mesh.face_areas), GRID.face_areas)


def test_layers_have_options_of_their_own():
    layers = [(LARGE, {}), ([0, 4, 8], {"open": True})]
    closed, opened = catamaran.draw(GRID, layers).layers
    assert closed.curves[0].closed and not opened.curves[0].closed
    assert len(opened.curves[0].edges) == 8 and len(closed.curves[0].edges) == 24
    with pytest.raises(TypeError, match="layers: unknown options opened"):
        catamaran.draw(GRID, [(LARGE, {"opened": True})])
    with pytest.raises(ValueError, match="layers: -1 is not the number of a vertex"):
        catamaran.draw(GRID, [([-1, 3, 5], {})])
    with pytest.raises(ValueError, match="mode: 'x' is not one of"):
        catamaran.draw(GRID, [(LARGE, {"mode": "x"})])


def test_regions_are_masks_with_an_algebra():
    found = catamaran.draw(GRID, [(LARGE, {}), (SMALL, {})])
    mesh = found.refined.mesh
    large, small = (
        catamaran.enclosed_faces(mesh, layer.curves[0].edges, seeds=[40]) for layer in found.layers
    )
    assert np.isclose(area(mesh, large), 36 / 64) and np.isclose(area(mesh, small), 16 / 64)
    ring = large & ~small
    assert np.isclose(area(mesh, ring), 20 / 64) and np.array_equal(ring, large ^ small)
    both = np.vstack([layer.curves[0].edges for layer in found.layers])
    rim = catamaran.region_boundary(mesh, ring)
    assert np.array_equal(rim, np.unique(both, axis=0))
    # Crossing both curves leads to the other side twice.
    assert np.array_equal(catamaran.enclosed_faces(mesh, both), ring)
    assert np.array_equal(catamaran.enclosed_faces(mesh, both, side="large"), ~ring)
    part = mesh.submesh(np.flatnonzero(ring)).mesh
    assert np.isclose(part.area, 20 / 64) and len(part.boundary_loops) == 2


def test_what_encloses_nothing_is_refused():
    way = np.column_stack([np.arange(36, 40), np.arange(37, 41)])
    with pytest.raises(ValueError, match="has the same region on both sides"):
        catamaran.enclosed_faces(GRID, way)
    with pytest.raises(ValueError, match="along: no edge joins vertices 0 and 80"):
        catamaran.enclosed_faces(GRID, [[0, 80]])
    with pytest.raises(ValueError, match="seeds: vertex 37 is on the curve"):
        catamaran.enclosed_faces(GRID, way, seeds=[37])
    with pytest.raises(ValueError, match="along: expected 2 columns, got 3"):
        catamaran.cut(GRID, GRID.f)
    with pytest.raises(TypeError, match="region: int64, where each face has a truth value"):
        catamaran.region_boundary(GRID, [0, 1, 2])
    with pytest.raises(ValueError, match="region: expected 128 x 1, got 3 x 1"):
        catamaran.region_boundary(GRID, [True, False, True])


def test_meshes_are_cut_open():
    mesh = shapes.torus(20, 10)
    tube = np.sort(np.column_stack([np.arange(10), np.roll(np.arange(10), -1)]), axis=1)
    edges = set(map(tuple, mesh.edges))
    assert set(map(tuple, tube)) <= edges
    found = catamaran.cut(mesh, tube)
    report = found.mesh.validate()
    # A cylinder.
    assert (report.components, report.genus, report.boundary_loops) == (1, 0, 2)
    assert sorted(found.vertices[len(mesh.v) :]) == list(range(10))
    assert np.array_equal(found.mesh.v, mesh.v[found.vertices])
    assert np.array_equal(found.vertices[found.mesh.f], mesh.f)
    assert np.array_equal(found.faces, np.arange(len(mesh.f)))


def test_points_on_faces_become_vertices():
    faces, inside = [0, 0, 5, 9], [[0.2, 0.3, 0.5], [0.6, 0.2, 0.2], [0.5, 0.5, 0], [0, 0, 1]]
    points = np.einsum("ij,ijk->ik", inside, GRID.v[GRID.f[faces]])
    (mesh, *_), places = catamaran.place(GRID, faces, inside)
    assert np.allclose(mesh.v[places], points) and len(mesh.v) == len(GRID.v) + 3
    assert np.isclose(mesh.area, GRID.area) and mesh.validate().problems == []
    near = catamaran.place(GRID, faces, inside, insert=False)
    assert np.array_equal(near.refined.mesh.f, GRID.f)
    assert near.vertices[0] == GRID.f[0, 2] and near.vertices[3] == GRID.f[9, 2]
    # Where the vertices of a decimation are, which can be samples of a curve then.
    small = catamaran.decimate(shapes.torus(), 50)
    origin = small.origin
    found = catamaran.place(shapes.torus(), origin.face, origin.barycentric)
    assert np.allclose(found.refined.mesh.v[found.vertices], small.carried(*shapes.torus()[::-1]))
    with pytest.raises(ValueError, match="faces: site 1: face 999 is out of range"):
        catamaran.place(GRID, [0, 999], inside[:2])
    with pytest.raises(ValueError, match="wrong barycentric coordinates"):
        catamaran.place(GRID, [0], [[0.5, 0.5, 0.5]])
    with pytest.raises(ValueError, match="barycentric: 4 rows for 1 faces"):
        catamaran.place(GRID, [0], inside)
