"""Distances, repair, filters and signatures of meshes."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

import catamaran
from catamaran import shapes


def edges(v, f):
    """The graph of the edges, with their lengths."""
    i, j = f[:, [0, 1, 2]].ravel(), f[:, [1, 2, 0]].ravel()
    i, j = np.unique(np.sort([i, j], axis=0), axis=1)
    return coo_array((np.linalg.norm(v[i] - v[j], axis=1), (i, j)), shape=(len(v), len(v)))


def test_distances_along_edges_are_those_of_scipy():
    v, f = mesh = shapes.figure(5)
    expected = dijkstra(edges(v, f).tocsr(), directed=False, indices=[3, 200])
    found = catamaran.distances(mesh, [3, 200], method="edges")
    assert np.allclose(found, expected.min(axis=0), rtol=1e-12)
    path = catamaran.shortest_path(v, f, 3, np.int64(200))
    assert path.vertices[0] == 3 and path.vertices[-1] == 200
    assert np.isclose(path.length, expected[0, 200]) and np.array_equal(
        path.points, v[path.vertices]
    )
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    assert np.isclose(steps.sum(), path.length)


def test_distances_by_heat_are_those_on_a_sphere():
    v, f = mesh = shapes.icosphere(4)
    found = catamaran.distances(mesh, [0])
    expected = np.arccos(np.clip(v @ v[0], -1, 1))
    assert np.abs(found - expected).max() < 0.04
    assert np.all(found >= np.linalg.norm(v - v[0], axis=1) - 1e-6)
    assert np.all(found <= catamaran.distances(mesh, [0], method="edges") + 1e-6)
    # Another component is infinitely far away.
    two = np.vstack([v, v + 5]), np.vstack([f, f + len(v)])
    assert np.isinf(catamaran.distances(*two, [0])[len(v) :]).all()
    path = catamaran.shortest_path(*two, 0, len(v))
    assert np.isinf(path.length) and len(path.vertices) == 0
    with pytest.raises(ValueError, match="method: 'x' is not one of"):
        catamaran.distances(mesh, [0], method="x")
    with pytest.raises(ValueError, match="sources: -1 is not the number of a vertex"):
        catamaran.distances(mesh, [-1])
    with pytest.raises(ValueError, match="time"):
        catamaran.distances(mesh, [0], time=-1.0)


def test_exact_distances_and_paths_are_straight_on_a_plane():
    v, f = mesh = shapes.grid(6, 4)
    found = catamaran.distances(mesh, [0, 12], method="exact")
    expected = np.linalg.norm(v[:, None] - v[[0, 12]], axis=2).min(axis=1)
    assert np.allclose(found, expected, rtol=1e-12, atol=1e-14)
    path = catamaran.geodesic_path(mesh, [0, 12, 33])
    assert np.isclose(path.length, np.linalg.norm(v[12]) + np.linalg.norm(v[33] - v[12]))
    assert np.allclose(np.einsum("ij,ijk->ik", path.weights, v[f[path.faces]]), path.points)
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    assert np.isclose(steps.sum(), path.length)
    two = np.vstack([v, v + 5]), np.vstack([f, f + len(v)])
    assert np.isinf(catamaran.distances(*two, [0], method="exact")[len(v) :]).all()
    path = catamaran.geodesic_path(*two, [0, len(v)])
    assert np.isinf(path.length) and path.points.shape == (0, 3)
    for through, why in (
        ([0], "at least two"),
        ([0, 35], "vertex 35 is out of range"),
        ([35, 0], "vertex 35 is out of range"),
    ):
        with pytest.raises(ValueError, match=f"through: {why}"):
            catamaran.geodesic_path(mesh, through)
    with pytest.raises(ValueError, match="too short"):
        catamaran.distances(np.zeros((3, 3)), [[0, 1, 2]], [0], method="exact")


def test_exact_distances_and_paths_start_and_end_inside_faces():
    v, f = mesh = shapes.grid(6, 4)
    faces, weights = [7, 40], np.array([[0.2, 0.3, 0.5], [0.6, 0.0, 0.4]])
    ends = np.einsum("ij,ijk->ik", weights, v[f[faces]])
    found = catamaran.distances(mesh, faces, weights=weights, method="exact")
    expected = np.linalg.norm(v[:, None] - ends, axis=2).min(axis=1)
    assert np.allclose(found, expected, rtol=1e-12, atol=1e-14)
    path = catamaran.geodesic_path(mesh, faces, weights=weights)
    assert np.isclose(path.length, np.linalg.norm(ends[1] - ends[0]), rtol=1e-12)
    assert np.allclose(path.points[[0, -1]], ends)
    # The points of a path are points that a path leads through.
    again = catamaran.geodesic_path(mesh, path.faces, weights=path.weights)
    assert np.isclose(again.length, path.length, rtol=1e-12)
    for arguments, why in (
        ((faces, weights[:1]), r"weights: 1 rows for 2 faces \(sources\)"),
        (([7, 48], weights), "sources: face 48 is out of range: 48 faces"),
        ((faces, 2 * weights), "sources: face 7: wrong barycentric coordinates"),
    ):
        with pytest.raises(ValueError, match=why):
            catamaran.distances(mesh, arguments[0], weights=arguments[1], method="exact")
    with pytest.raises(ValueError, match='weights: points of faces are for method="exact"'):
        catamaran.distances(mesh, faces, weights=weights)


def test_geodesics_are_traced_from_a_point_in_a_direction():
    v, f = mesh = shapes.grid(6, 4)
    trace = catamaran.trace_geodesic(mesh, 0, [3, 4, 0], 1.0)
    assert trace.end == "complete" and trace.length == 1.0
    assert np.allclose(trace.points[-1], [0.6, 0.8, 0]) and np.allclose(
        trace.direction, [0.6, 0.8, 0]
    )
    back = catamaran.trace_geodesic(
        mesh, trace.faces[-1], -trace.direction, 0.5, weights=trace.weights[-1]
    )
    assert np.allclose(back.points[-1], [0.3, 0.4, 0], atol=1e-12)
    stopped = catamaran.trace_geodesic(mesh, 0, np.array([1.0, 0.5, 3.0]), 2.0)
    assert stopped.end == "boundary" and np.isclose(stopped.length, np.hypot(1, 0.5))
    for arguments, why in (
        ((35, [1, 0, 0], 1), "start: vertex 35 is out of range"),
        ((0, [0, 0, 0], 1), "direction: must be finite and not 0"),
        ((0, [0, 0, 1], 1), "direction: points away from the surface at vertex 0"),
        ((0, [1, 0, 0], -1), "length: must be finite and at least 0"),
    ):
        with pytest.raises(ValueError, match=why):
            catamaran.trace_geodesic(mesh, *arguments)
    with pytest.raises(ValueError, match="start: face 48 is out of range"):
        catamaran.trace_geodesic(mesh, 48, [1, 0, 0], 1, weights=[1, 0, 0])


def test_repair_joins_a_soup():
    v, f = shapes.icosphere(1)
    soup = v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    for weld in ("exact", "seams", 1e-9):
        mesh, places, report = catamaran.repair(*soup, weld=weld)
        assert mesh.v.shape == v.shape and len(mesh.f) == len(f) and len(report) >= 1
        assert np.allclose(mesh.v[places], soup[0], atol=1e-8)
    same = catamaran.repair(*soup)
    assert np.array_equal(same.mesh.v, soup[0]) and np.array_equal(same.vertices, np.arange(240))
    with pytest.raises(ValueError, match="weld: 'x' is not one of"):
        catamaran.repair(*soup, weld="x")
    with pytest.raises(TypeError, match="^orient: "):
        catamaran.repair(*soup, orient=2)


def test_repair_orients_fills_and_leaves_out():
    v, f = shapes.icosphere(2)

    def volume(mesh):
        a, b, c = mesh.v[mesh.f].transpose(1, 0, 2)
        return np.einsum("ij,ij->", a, np.cross(b, c)) / 6

    flipped = f.copy()
    flipped[::3] = flipped[::3, ::-1]
    expected = volume(catamaran.Mesh(v, f))
    assert np.isclose(volume(catamaran.repair(v, flipped, orient=True).mesh), expected)
    # Of a hole with 3 edges.
    filled = catamaran.repair(v, f[1:], fill_holes=3).mesh
    assert len(filled.f) == len(f) and np.isclose(volume(filled), expected)
    small = 0.01 * v[:, ::-1] + 9
    both = np.vstack([v, small]), np.vstack([f, f + len(v)])
    for steps in ({"keep_largest": 1}, {"drop_specks": 0.01}):
        mesh, places, _ = catamaran.repair(*both, compact=True, **steps)
        kept = catamaran.repair(*mesh, compact=True).mesh
        assert np.array_equal(kept.v, v) and len(kept.f) == len(f)


def test_filters_multiply_coefficients(rng):
    v, f = shapes.torus(20, 10)
    basis = catamaran.Eigenbasis(v, f, 30)
    g = rng.standard_normal((len(v), 2))
    phi, mass = basis.functions, basis.mass
    coefficients = phi.T @ (mass @ g)
    gains = np.exp(-0.3 * basis.values)
    found = basis.filter(g, lambda x: np.exp(-0.3 * x))
    assert np.allclose(found, phi @ (gains[:, None] * coefficients))
    assert np.allclose(basis.filter(g, np.ones_like, 1.0), g)
    low = basis.filter(g[:, 0], lambda x: x < 2)
    assert low.shape == (len(v),)
    assert np.allclose(basis.filter(low, lambda x: x < 2), low)
    smooth, details = basis.split(g)
    assert np.allclose(smooth + details, g) and np.allclose(phi.T @ (mass @ details), 0, atol=1e-10)
    with pytest.raises(ValueError, match="gain"):
        basis.filter(g, lambda x: [1.0, 2.0])


def test_signatures_are_their_sums():
    v, f = shapes.figure(5)
    basis = catamaran.Eigenbasis(v, f, 20)
    values, squares = basis.values, basis.functions**2
    found, times = basis.heat_kernel_signature(12)
    assert found.shape == (len(v), 12) and np.all(np.diff(times) > 0)
    assert np.allclose(found, squares @ np.exp(-np.outer(values, times)))
    own, same = basis.heat_kernel_signature(times=[0.5, 2.0])
    assert np.array_equal(same, [0.5, 2.0])
    assert np.allclose(own, squares @ np.exp(-np.outer(values, [0.5, 2.0])))
    found, energies = basis.wave_kernel_signature(10)
    logarithms = np.log(values[1:])
    sigma = 7 * np.ptp(logarithms) / (10 + 27)
    weights = np.exp(-((energies - logarithms[:, None]) ** 2) / (2 * sigma**2))
    assert np.allclose(found, squares[:, 1:] @ (weights / weights.sum(axis=0)))


def test_decimation_carries_attributes():
    v, f = shapes.torus(40, 20)
    # Samples that nothing moves are points of the input.
    found = catamaran.decimate(v, f, 150, relaxation=0)
    assert np.allclose(found.carried(f, v), found.v, atol=1e-9)
    heights = found.carried(f, v[:, 2])
    assert heights.shape == (150,) and np.allclose(heights, found.v[:, 2], atol=1e-9)
    assert np.allclose(found.carried(f, np.ones((len(v), 3, 2))), 1)


def test_details_are_carried_to_another_pose():
    v, f = shapes.figure(5)
    posed, _ = shapes.figure(5, 0.5)
    # A mesh that gets its own details stays as it is, up to what products can't express.
    same = catamaran.transfer_details((v, f), catamaran.Mesh(v, f), smooth=8, k=20)
    size = np.ptp(v)
    assert np.array_equal(same.f, f)
    assert np.linalg.norm(same.v - v, axis=1).mean() < 0.02 * size
    # A mesh of twice the size gets details of twice the height, of the same shape.
    large = catamaran.transfer_details((v, f), (2 * posed, f), smooth=8, k=20)
    small = catamaran.transfer_details((v, f), (posed, f), smooth=8, k=20)
    assert np.allclose(large.v, 2 * small.v, atol=1e-6 * size)
    with pytest.raises(ValueError, match="points"):
        catamaran.transfer_details((v, f), (posed, f), smooth=8, k=20, points=[-1])


def test_a_shape_is_found_from_its_spectrum():
    v, f = shapes.disk(8, 24)
    wanted = catamaran.eigsh(v * [1.0, 1.2, 1.0], f, 6, boundary="dirichlet").values
    found = catamaran.shape_from_spectrum(v, f, wanted, tolerance=1e-2)
    assert found.error <= 1e-2 and 0 < found.steps <= 60
    values = catamaran.eigsh(found.mesh, k=6, boundary="dirichlet").values
    assert np.allclose(values, found.values, rtol=1e-6)
    assert np.isclose(np.mean(np.abs(values / wanted - 1)), found.error, rtol=1e-3)
    with pytest.raises(ValueError, match="eigenvalues"):
        catamaran.shape_from_spectrum(v, f, wanted[::-1])


def test_a_union_is_located_on_the_template_only():
    disk = shapes.disk(12, 40)
    with pytest.raises(ValueError, match="template"):
        catamaran.locate_union([disk, disk], shapes.icosphere(2))


def test_repair_leaves_out_faces_that_have_a_vertex_twice():
    v, f = shapes.icosphere(1)
    broken = np.vstack([f[:4], [[3, 7, 7], [2, 2, 2]], f[4:]])
    with pytest.raises(ValueError, match=r"face 4: has the same vertex twice: \[3, 7, 7\]"):
        catamaran.repair(v, broken, orient=True)
    for steps in ({"everything": True}, {"drop_degenerate": True}):
        mesh, places, report = catamaran.repair(v, broken.tolist(), **steps)
        assert np.array_equal(mesh.f, f) and np.array_equal(places, np.arange(len(v)))
        assert report[0] == "left out    facets with two equal corners: 2"
        assert not catamaran.repair(v, f, **steps).report[0].startswith("left out")


def test_one_source_may_be_a_number():
    mesh = shapes.grid(4, 4)
    for method in ("heat", "exact", "edges"):
        found = catamaran.distances(mesh, np.int64(3), method=method)
        assert np.array_equal(found, catamaran.distances(mesh, [3], method=method))
    way = np.array([6, 7, 8, 13, 18, 17, 16, 11, 6])
    around = np.column_stack([way[:-1], way[1:]])
    mask = catamaran.enclosed_faces(mesh, around, seeds=[12])
    one = catamaran.enclosed_faces(mesh, around, seeds=12)
    assert mask.sum() == 8 and np.array_equal(mask, one)
