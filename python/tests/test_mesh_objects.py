"""Meshes of other packages, and conversions to them."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import catamaran
from catamaran import shapes

V, F = shapes.icosphere(2)


def of_trimesh():
    return pytest.importorskip("trimesh").Trimesh(V, F, process=False)


def of_meshio():
    meshio = pytest.importorskip("meshio")
    # Cells of no area beside the triangles, which are in two blocks.
    cells = [("triangle", F[:100]), ("line", [[0, 1]]), ("triangle", F[100:])]
    return meshio.Mesh(V, cells)


def of_pyvista():
    corners = np.full((len(F), 1), 3)
    return SimpleNamespace(points=V, faces=np.hstack([corners, F]).ravel())


def of_grid():
    # The kinds of cells as pyvista numbers them, bytes of VTK: a line and triangles.
    return SimpleNamespace(points=V, cells_dict={np.uint8(3): [[0, 1]], np.uint8(5): F})


MAKERS = [of_trimesh, of_meshio, of_pyvista, of_grid, lambda: catamaran.Mesh(V, F)]


@pytest.mark.parametrize("make", MAKERS)
def test_functions_take_meshes_as_they_take_arrays(make, tmp_path):
    mesh = make()
    calls = [
        lambda *m: catamaran.eigsh(*m, 5).values,
        lambda *m: catamaran.eigsh(*m, k=5).vectors,
        lambda *m: catamaran.laplacian(*m, kind="intrinsic").stiffness.toarray(),
        lambda *m: catamaran.shape_dna(*m, 5),
        lambda *m: catamaran.decimate(*m, 60).v,
        lambda *m: catamaran.farthest_points(*m, 7),
        lambda *m: catamaran.curve(*m, [0, 5, 9]).curves[0].points,
        lambda *m: catamaran.eigenproducts(*m, k=3).functions,
        lambda *m: catamaran.slime(*m, 2, agents=50, size=160).texture,
        lambda *m: catamaran.Eigenbasis(*m, k=4).functions,
        lambda *m: catamaran.count_below(*m, 3.0),
        lambda *m: catamaran.free_components(*m),
        lambda *m: catamaran.gradient(*m).toarray(),
        lambda *m: catamaran.divergence(*m).toarray(),
        lambda *m: catamaran.shot(*m, 0.5),
        lambda *m: catamaran.geodesic_rings(*m, V, 0.5, 2),
        lambda *m: catamaran.draw(*m, [([0, 5, 9], {})]).refined.mesh.v,
        lambda *m: catamaran.place(*m, [3], [[0.2, 0.3, 0.5]]).refined.mesh.v,
        lambda *m: catamaran.cut(*m, F[:1, :2]).mesh.v,
        lambda *m: catamaran.enclosed_faces(*m, F[0, [0, 1, 1, 2, 2, 0]].reshape(3, 2)),
        lambda *m: catamaran.region_boundary(*m, np.arange(len(F)) < 9),
        lambda *m: np.frombuffer(catamaran.mesh_to_bytes(*m, "off"), np.uint8),
    ]
    for call in calls:
        assert np.array_equal(call(mesh), call(V, F))
    for source in (mesh, (V, F)):
        moved = catamaran.transfer(source, mesh, V, k=4)
        assert np.array_equal(moved, catamaran.transfer((V, F), (V, F), V, k=4))
    catamaran.write_mesh(tmp_path / "a.off", mesh)
    v, f = catamaran.read_mesh(tmp_path / "a.off")
    assert np.array_equal(v, V) and np.array_equal(f, F)


def test_parts_of_unions_may_be_meshes():
    disk = shapes.disk(12, 40)
    parts = [catamaran.Mesh(*disk), (disk.v * 0.8, disk.f)]
    found = catamaran.union_spectrum(parts).parts[0]
    assert np.array_equal(found, catamaran.union_spectrum([tuple(part) for part in parts]).parts[0])


def test_meshes_are_given_back():
    trimesh = pytest.importorskip("trimesh")
    small = catamaran.decimate(V, F, 60).mesh
    back = small.to_trimesh()
    assert isinstance(back, trimesh.Trimesh) and back.is_watertight
    assert np.array_equal(back.vertices, small.v) and np.array_equal(back.faces, small.f)
    assert small.to_trimesh(face_colors=[[255, 0, 0, 255]] * len(small.f)).visual.kind == "face"
    pytest.importorskip("meshio")
    back = small.to_meshio(point_data={"x": small.v[:, 0]})
    assert np.array_equal(back.points, small.v)
    assert np.array_equal(back.cells_dict["triangle"], small.f)
    for mesh in (shapes.torus(10, 8), catamaran.wilt(catamaran.grow_plant(20), frames=1).mesh(0)):
        assert isinstance(mesh, catamaran.Mesh) and len(mesh) == 2


def test_what_is_no_triangle_mesh_is_refused():
    meshio = pytest.importorskip("meshio")
    quads = meshio.Mesh(V, [("quad", [[0, 1, 2, 3]]), ("triangle", F)])
    with pytest.raises(ValueError, match="mesh: cells of quad, expected triangles"):
        catamaran.eigsh(quads, k=3)
    tetrahedra = SimpleNamespace(points=V, cells_dict={np.uint8(10): [[0, 1, 2, 3]]})
    with pytest.raises(ValueError, match="mesh: cells of 10, expected triangles"):
        catamaran.eigsh(tetrahedra, k=3)
    quads = SimpleNamespace(points=V, faces=np.array([4, 0, 1, 2, 3, 3, 0, 1]))
    with pytest.raises(ValueError, match="mesh: faces that are not triangles"):
        catamaran.laplacian(quads)
    with pytest.raises(TypeError, match="f: missing"):
        catamaran.write_mesh("a.off", V)


def test_faces_beside_a_mesh_or_a_basis_are_refused():
    with pytest.raises(TypeError, match="f: not together with a mesh"):
        catamaran.Eigenbasis(catamaran.Mesh(V, F), 4)
    with pytest.raises(TypeError, match="f: not together with a basis"):
        catamaran.eigenproducts(catamaran.Eigenbasis(V, F, 4), 3)


@pytest.mark.parametrize("make", [of_trimesh, of_meshio, of_pyvista, of_grid, lambda: (V, F)])
def test_a_mesh_is_made_of_one_of_another_package(make):
    mesh = catamaran.Mesh(make())
    assert type(mesh.v) is type(mesh.f) is np.ndarray
    assert np.array_equal(mesh.v, V) and np.array_equal(mesh.f, F)
    assert mesh.area == catamaran.Mesh(V, F).area
    again = pickle.loads(pickle.dumps(mesh))
    assert isinstance(again, catamaran.Mesh) and np.array_equal(again.f, F)


def test_what_is_taken_for_a_mesh_says_how_to_make_one(tmp_path):
    for name in ("a.ply", tmp_path / "a.ply"):
        with pytest.raises(TypeError, match=r"v: expected .*, got a name: read_mesh\('.*a.ply'\)"):
            catamaran.eigsh(name, k=3)
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene([of_trimesh()])
    with pytest.raises(TypeError, match=r"v: expected a mesh, got a Scene: to_mesh\(\)"):
        catamaran.repair(scene)
    assert np.array_equal(catamaran.repair(scene.to_mesh()).mesh.f, F)
    with pytest.raises(TypeError, match="v: expected a mesh, or vertices and faces, got int"):
        catamaran.Mesh(3)
    with pytest.raises(ValueError, match="v: 3 entries are masked"):
        catamaran.Mesh(np.ma.array(V, mask=np.arange(V.size).reshape(V.shape) < 3), F)


def test_colours_of_bytes_come_back_through_a_decimation(rng, tmp_path):
    colors = rng.integers(0, 2, (len(V), 4), dtype=np.uint8) * 255
    found = catamaran.decimate(V, F, 60)
    carried = found.carried(catamaran.Mesh(V, F), colors)
    assert np.array_equal(carried, found.carried(F, colors))
    # A point of three equal colours has this one, whatever rounding does to its weights.
    assert carried.min() >= 0 and carried.max() <= 255 and (carried == 255).any()
    expected = np.einsum("ij,ijk->ik", found.origin.barycentric, colors[F[found.origin.face]])
    assert np.allclose(carried, expected)
    bytes_of = carried.round().astype(np.uint8)
    catamaran.write_mesh(tmp_path / "a.ply", found.mesh, colors=bytes_of)
    _, _, more = catamaran.read_mesh(tmp_path / "a.ply", attributes=True)
    assert more["notes"] == [] and np.array_equal(more["colors"] * 255, bytes_of)
    of_shares = catamaran.mesh_to_bytes(found.mesh, "ply", colors=bytes_of / 255)
    assert catamaran.mesh_to_bytes(found.mesh, "ply", colors=bytes_of) == of_shares


def test_carried_values_have_a_row_for_each_vertex():
    found = catamaran.decimate(V, F, 60)
    with pytest.raises(ValueError, match=r"values: expected a row for each vertex, at least 162"):
        found.carried(F, np.ones(5))
    with pytest.raises(ValueError, match=r"f: expected at least .* faces, m x 3, got \(5, 3\)"):
        found.carried(F[:5], V)
    with pytest.raises(ValueError, match=r"f: expected .*, got \(162, 4\)"):
        found.carried(np.ones((162, 4)), F)
    turning = np.exp(1j * V[:, 0])
    parts = [found.carried(F, part) for part in (turning.real, turning.imag)]
    assert np.allclose(found.carried(F, turning), parts[0] + 1j * parts[1])
