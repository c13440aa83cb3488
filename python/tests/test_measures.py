"""What a mesh knows about itself, its parts, and surfaces of lattices."""

import warnings

import numpy as np
import pytest

import catamaran
from catamaran import Mesh, shapes

TORUS = shapes.torus(40, 20)
DISK = shapes.disk(6, 20)
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def corners(mesh):
    return mesh.v[mesh.f].transpose(1, 0, 2)


def test_areas_normals_and_volume_are_their_sums():
    for mesh in (TORUS, DISK, shapes.figure(5)):
        a, b, c = corners(mesh)
        doubled = np.cross(b - a, c - a)
        areas = np.linalg.norm(doubled, axis=1) / 2
        assert np.allclose(mesh.face_areas, areas) and np.isclose(mesh.area, areas.sum())
        assert np.allclose(mesh.face_normals, doubled / (2 * areas[:, None]))
        sums = np.zeros_like(mesh.v)
        thirds = np.zeros(len(mesh.v))
        for corner in mesh.f.T:
            np.add.at(sums, corner, doubled)
            np.add.at(thirds, corner, areas / 3)
        sums /= np.linalg.norm(sums, axis=1)[:, None]
        assert np.allclose(mesh.vertex_normals, sums) and np.allclose(mesh.vertex_areas, thirds)
        assert np.allclose(mesh.vertex_areas, catamaran.laplacian(mesh).mass.diagonal())
        lengths = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))]
        qualities = 4 * np.sqrt(3) * areas / (sum(lengths) * np.max(lengths, axis=0))
        assert np.allclose(mesh.qualities, qualities)
    a, b, c = corners(TORUS)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert np.isclose(TORUS.volume, volume)
    assert np.isclose(Mesh(TORUS.v, TORUS.f[:, ::-1]).volume, -volume)
    flipped = np.vstack([TORUS.f[:1, ::-1], TORUS.f[1:]])
    for f in (TORUS.f[1:], flipped, TORUS.f[:0]):
        assert Mesh(TORUS.v, f).volume is None
    assert DISK.volume is None


def test_topology_is_that_of_the_faces():
    for mesh in (TORUS, DISK):
        pairs = mesh.f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        assert np.array_equal(mesh.edges, np.unique(np.sort(pairs, axis=1), axis=0))
    (rim,) = DISK.boundary_loops
    radii = np.linalg.norm(DISK.v, axis=1)
    assert sorted(rim) == list(np.flatnonzero(radii > radii.max() - 1e-9))
    assert TORUS.boundary_loops == []
    two = Mesh(np.vstack([TORUS.v, DISK.v]), np.vstack([TORUS.f, DISK.f + len(TORUS.v)]))
    assert np.array_equal(two.components, np.repeat([0, 1], [len(TORUS.f), len(DISK.f)]))
    report = two.validate()
    v, e, f = len(two.v), len(two.edges), len(two.f)
    assert (report.vertices, report.edges, report.faces, report.components) == (v, e, f, 2)
    assert report.euler_characteristic == v - e + f and report.boundary_edges == len(rim)
    assert (report.genus, report.boundary_loops, report.is_orientable) == (1, 1, True)
    assert shapes.genus(3).validate().genus == 3
    assert report.problems == [] and report.needs_repair is None
    assert str(report) == report.report and "components  2" in str(report)


def test_problems_are_named():
    def problems(*faces):
        return dict(Mesh(SQUARE, np.array(faces)).validate().problems)

    assert problems([0, 1, 2]) == {"vertices without a face": "vertex 3"}
    found = problems([0, 1, 2], [0, 2, 3], [2, 0, 1])
    assert found["repeated faces"] == "face 2 as face 0"
    assert found["edges with more than two faces"] == "edge 0-2 of 3 faces (0, 1, 2)"
    twice = Mesh(SQUARE, np.array([[0, 1, 2], [1, 2, 0]])).validate().needs_repair
    assert twice == "1 repeated faces: face 1 has the vertices of face 0"
    collapsed = Mesh(SQUARE, np.array([[0, 1, 2], [0, 2, 3], [1, 1, 3], [2, 2, 2]])).validate()
    assert collapsed.faces == 2
    place = "left out, the first at face 2"
    assert collapsed.problems == [("faces that have a vertex twice", place)]
    assert collapsed.needs_repair == f"faces that have a vertex twice: {place}"
    flat = Mesh(SQUARE * [1, 0, 0], np.array([[0, 1, 2], [0, 2, 3]])).validate()
    assert ("faces without area", "face 0") in flat.problems
    # A strip with a half turn.
    strip = np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4], [4, 5, 1], [5, 0, 1]])
    bent = np.array([[0, 0, 0], [0, 0, 1], [2, 0, 0], [2, 1, 1], [1, 2, 0], [1, 3, 1.0]])
    report = Mesh(bent, strip).validate()
    assert not report.is_orientable and report.genus == 1
    with pytest.raises(ValueError, match="edge 0-2: has 3 faces"):
        _ = Mesh(SQUARE, np.array([[0, 1, 2], [0, 2, 3], [2, 0, 1]])).boundary_loops


def test_faces_that_meet_others_are_found():
    assert len(TORUS.intersecting_faces()) == 0
    crossed = np.array([[0.5, 0.5, -1], [0.5, 0.5, 1], [3, 3, 0.5]])
    mesh = Mesh(np.vstack([SQUARE, crossed]), np.array([[0, 1, 3], [4, 5, 6], [1, 2, 3]]))
    assert np.array_equal(mesh.intersecting_faces(threads=1), [0, 1, 2])


def test_meshes_are_compared_both_ways():
    sphere = shapes.icosphere(4)
    found = sphere.compare((1.5 * sphere.v, sphere.f))
    assert abs(found.out.mean - 0.5) < 0.01 and found.back.largest <= 0.5 + 1e-9
    assert found.out.angle < 2
    assert found == sphere.compare(Mesh(1.5 * sphere.v, sphere.f), threads=1)
    same = sphere.compare(sphere)
    assert same.out.largest < 1e-9 and same.out == same.back
    with pytest.raises(ValueError, match="mesh: has no face"):
        sphere.compare(Mesh(sphere.v, sphere.f[:0]))
    for wrong in (None, sphere.v, (sphere.v,)):
        with pytest.raises(TypeError, match="other: expected a mesh, or vertices and faces"):
            sphere.compare(wrong)


def test_sizes_beyond_the_range_of_areas_are_refused():
    sphere = shapes.icosphere(0)
    v = sphere.v.copy()
    v[3] *= 1e80
    far = Mesh(v, sphere.f)
    names = "area volume face_areas vertex_areas qualities face_normals vertex_normals".split()
    calls = [lambda name=name: getattr(far, name) for name in names]
    calls += [far.quality, lambda: far.compare(sphere), lambda: sphere.compare(far)]
    for call in calls:
        with pytest.raises(ValueError, match="vertex 3: position .* is out of range"):
            call()
    assert far.edges.shape == (30, 2) and far.boundary_loops == []


def test_quality_and_difference_of_a_decimation():
    even = shapes.icosphere(0).quality()
    assert np.isclose(even.mean_quality, 1) and even.area_variation < 1e-12
    assert even.mean_valence == 5
    q, areas = DISK.qualities, DISK.face_areas
    found = DISK.quality()
    expected = (areas.mean(), areas.std() / areas.mean(), q.mean(), q.std(), q.min())
    assert np.allclose(found[:5], expected) and found.non_manifold_edges == 0
    small = catamaran.decimate(TORUS, 200)
    found = small.difference(TORUS)
    compared = TORUS.compare(small.mesh)
    # Of the vertices alone.
    assert 0 < found.hausdorff <= max(compared.out.largest, compared.back.largest) + 1e-12
    assert 0 < found.chamfer <= 2 * found.hausdorff**2
    distances = np.linalg.norm(TORUS.v[:, None] - small.v, axis=2).min(axis=1)
    assert np.isclose(found.printed_hausdorff, distances.max())


def test_parts_know_where_they_are():
    chosen = np.flatnonzero(TORUS.face_normals[:, 2] > 0.5)
    mesh, vertices, faces = TORUS.submesh(chosen[::-1])
    assert np.array_equal(faces, chosen) and np.array_equal(mesh.v, TORUS.v[vertices])
    assert np.array_equal(vertices[mesh.f], TORUS.f[faces])
    two = Mesh(np.vstack([DISK.v, TORUS.v]), np.vstack([DISK.f, TORUS.f + len(DISK.v)]))
    part = two.component(1)
    assert np.array_equal(part.mesh.v, TORUS.v) and np.array_equal(part.mesh.f, TORUS.f)
    for wrong, match in [([0, 0], "face 0 is given twice"), ([9999], "9999"), ([-1], "faces: -1")]:
        with pytest.raises(ValueError, match=match):
            TORUS.submesh(wrong)
    with pytest.raises(TypeError, match="faces: truth values"):
        TORUS.submesh(TORUS.face_areas > 0)
    with pytest.raises(ValueError, match="component: 2 is not one of the 2"):
        two.component(2)


def test_isosurfaces_are_where_the_values_say():
    x, y, z = np.ogrid[-1.5:1.5:31j, -1.5:1.5:31j, -2:2:41j]
    values = 1 - x**2 - y**2 - (z / 1.5) ** 2
    how = {"origin": (-1.5, -1.5, -2), "step": (0.1, 0.1, 0.1)}
    ball = catamaran.isosurface(values, **how)
    # Linear values are too small, by 0.01 (1/4 + 1/4 + 1/9) at most, and so is the ball; vertices
    # are at least 1/1024 of an edge of the lattice away from its ends.
    assert ball.validate().genus == 0 and 0.99 < ball.volume / (2 * np.pi) < 1.001
    assert np.allclose(np.linalg.norm(ball.v / [1, 1, 1.5], axis=1), 1, atol=0.01)
    half = catamaran.isosurface(values[:16], open=True, **how)
    assert half.validate().boundary_loops == 1 and np.isclose(half.v[:, 0].max(), 0)
    assert catamaran.isosurface(values[:16], **how).boundary_loops == []
    labels = np.where(values > 0, "ball", "air")
    found = catamaran.label_surface(labels, "ball", **how)
    assert np.array_equal(found.f, catamaran.label_surface(values > 0, True, **how).f)
    halves = (found.v - [-1.5, -1.5, -2]) / 0.05
    assert np.allclose(halves, np.round(halves), atol=1e-6)
    with pytest.raises(ValueError, match="values: expected an array of 3 dimensions, got 2"):
        catamaran.isosurface(values[0])
    with pytest.raises(ValueError, match="lattice: steps must be positive"):
        catamaran.isosurface(values, step=(0.1, 0.0, 0.1))
    with pytest.raises(ValueError, match="values: not finite"):
        catamaran.isosurface(np.full((2, 2, 2), np.nan))
    with pytest.raises(ValueError, match="level: must not be NaN"):
        catamaran.isosurface(values, np.nan)


def test_masked_entries_are_refused():
    def masked(values):
        return np.ma.array(values, mask=np.arange(np.size(values)).reshape(np.shape(values)) == 0)

    refined = catamaran.place(DISK, [0], [[0.2, 0.3, 0.5]]).refined
    calls = [
        ("values", lambda: catamaran.isosurface(masked(np.ones((2, 2, 2))))),
        ("labels", lambda: catamaran.label_surface(masked(np.ones((2, 2, 2))), 1)),
        ("region", lambda: catamaran.region_boundary(DISK, masked(DISK.face_areas > 0))),
        ("values", lambda: refined.carried(masked(DISK.v[:, 0]))),
        ("uv", lambda: catamaran.mesh_to_bytes(DISK, "ply", uv=masked(DISK.v[DISK.f][:, :, :2]))),
        ("values", lambda: catamaran.decimate(TORUS, 200).carried(TORUS.f, masked(TORUS.v))),
    ]
    for name, call in calls:
        with pytest.raises(ValueError, match=f"{name}: 1 entries are masked"):
            call()


def test_values_of_any_type_and_order_are_one_function():
    rng = np.random.default_rng(3)
    values = rng.integers(-9, 9, (4, 5, 6))
    right = catamaran.isosurface(values, 0.5)
    orders = [np.asfortranarray(values, float), np.array(values, float), values.astype("f4")]
    for same in [*orders, np.repeat(values.astype(float), 2, axis=1)[:, ::2]]:
        found = catamaran.isosurface(same, 0.5)
        assert np.array_equal(found.v, right.v) and np.array_equal(found.f, right.f)


def test_files_in_memory_are_those_on_disk(tmp_path):
    colors = np.linspace(0, 1, 3 * len(DISK.v)).reshape(-1, 3)
    for name in ("obj", "ply", "off", "stl", "glb", "gltf"):
        path = tmp_path / f"mesh.{name}"
        with warnings.catch_warnings():
            # About what formats do not hold.
            warnings.simplefilter("ignore")
            data = catamaran.mesh_to_bytes(DISK, name, colors=colors)
            catamaran.write_mesh(path, DISK, colors=colors)
            v, f = catamaran.mesh_from_bytes(data, name)
            again = catamaran.read_mesh(path)
        assert data == path.read_bytes()
        assert np.array_equal(v, again.v) and np.array_equal(f, again.f)
    with pytest.warns(UserWarning, match="mesh.stl: .*colours"):
        catamaran.mesh_to_bytes(DISK, "stl", colors=colors)
    data = catamaran.mesh_to_bytes(*DISK, "ply", text=True)
    assert data.startswith(b"ply\nformat ascii")
    data = catamaran.mesh_to_bytes(DISK, "ply", colors=np.round(colors))
    more = catamaran.mesh_from_bytes(data, "ply", attributes=True)[2]
    assert np.array_equal(more["colors"][:, :3], np.round(colors))
    with pytest.raises(OSError, match="mesh.ply"):
        catamaran.mesh_from_bytes(b"OFF\n0 0 0\n", "ply")
    with pytest.raises(ValueError, match="text: this format has no text"):
        catamaran.mesh_to_bytes(DISK, "glb", text=True)
