"""Meshes: files, Laplacians, spectra beside libigl and scipy."""

import gzip
import warnings

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
import scipy.spatial

import catamaran
from catamaran import shapes
from conftest import data

igl = pytest.importorskip("igl")


@pytest.mark.parametrize(
    "name", ["icosphere", "torus", "knot", "genus", "figure", "grid", "disk", "cylinder", "terrain"]
)
def test_laplacians_are_those_of_libigl(name):
    v, f = getattr(shapes, name)()
    stiffness, mass, kept = catamaran.laplacian(v, f)
    theirs = -igl.cotmatrix(v, f)
    assert abs(stiffness - theirs).max() < 1e-9 * abs(theirs).max()
    theirs = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_BARYCENTRIC)
    assert abs(mass - theirs).max() < 1e-12 * abs(theirs).max()
    assert np.array_equal(kept, np.arange(len(v)))


def test_boundaries_and_masses():
    v, f = shapes.disk()
    stiffness, mass, kept = catamaran.laplacian(v, f, boundary="dirichlet", mass="full")
    rim = np.unique(
        igl.boundary_facets(f)[0]
        if isinstance(igl.boundary_facets(f), tuple)
        else igl.boundary_facets(f)
    )
    assert np.array_equal(kept, np.setdiff1d(np.arange(len(v)), rim))
    assert stiffness.shape == mass.shape == (len(kept), len(kept))
    assert not np.isin([3, 5], catamaran.laplacian(v, f, boundary=[3, 5]).kept).any()
    voronoi = catamaran.laplacian(v, f, mass="voronoi").mass
    assert abs(voronoi - igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_VORONOI)).max() < 1e-12
    values, vectors = catamaran.eigsh(v, f, 4, boundary="dirichlet")
    assert vectors.shape == (len(v), 4) and (vectors[rim] == 0).all()
    assert abs(values[0] - 5.78) < 0.15  # the first zero of J_0, squared


def test_spectra_are_those_of_scipy():
    v, f = shapes.torus(40, 20)
    stiffness, mass, _ = catamaran.laplacian(v, f)
    expected = scipy.sparse.linalg.eigsh(stiffness.tocsc(), 8, mass.tocsc(), sigma=-1e-3)[0]
    values, vectors = catamaran.eigsh(v, f, 8)
    assert np.allclose(values, expected, atol=1e-8)
    assert np.allclose(vectors.T @ mass @ vectors, np.eye(8), atol=1e-9)
    again = catamaran.eigsh(stiffness, mass, 8)
    assert np.array_equal(again.values, values)
    lumped = catamaran.eigsh(stiffness, mass.diagonal(), 8)
    assert np.array_equal(lumped.values, values)
    near = catamaran.eigsh(v, f, 3, sigma=2.0).values
    assert np.allclose(
        near, sorted(sorted(catamaran.eigsh(v, f, 40).values, key=lambda x: abs(x - 2.0))[:3])
    )
    # At an eigenvalue.
    assert np.allclose(catamaran.eigsh(stiffness, mass, 8, sigma=0.0).values, values, atol=1e-9)
    assert np.allclose(catamaran.eigsh(v, f, 1, sigma=values[7]).values, values[7], atol=1e-9)


def test_kinds_of_integers_and_strides():
    v, f = shapes.icosphere(2)
    expected = catamaran.laplacian(v, f).stiffness
    for kind in (np.int32, np.int64, np.uint32, np.uint64):
        assert abs(catamaran.laplacian(v, f.astype(kind)).stiffness - expected).max() == 0
    wide = np.zeros((len(v), 6))
    wide[:, ::2] = v
    assert (
        abs(catamaran.laplacian(wide[:, ::2], np.asfortranarray(f)).stiffness - expected).max() == 0
    )
    assert abs(catamaran.laplacian(v.tolist(), f.tolist()).stiffness - expected).max() == 0


def test_files(tmp_path):
    v, f = shapes.torus(20, 10)
    colors = np.random.default_rng(0).uniform(size=(len(v), 3))
    for name in ("a.ply", "a.obj", "a.off", "a.glb", "a.ply.gz"):
        catamaran.write_mesh(tmp_path / name, v, f)
        again, faces = catamaran.read_mesh(tmp_path / name)
        assert np.allclose(again, v, atol=1e-6) and np.array_equal(faces, f)
    catamaran.write_mesh(tmp_path / "b.ply", v, f, colors=colors)
    more = catamaran.read_mesh(tmp_path / "b.ply", attributes=True)[2]
    assert np.allclose(more["colors"][:, :3], colors, atol=1 / 255)
    uv = np.random.default_rng(0).uniform(size=(len(f), 3, 2))
    catamaran.write_mesh(tmp_path / "c.obj", v, f, uv=uv)
    assert np.allclose(catamaran.read_mesh(tmp_path / "c.obj", attributes=True)[2]["uv"], uv)
    with pytest.raises(OSError, match="exists"):
        catamaran.write_mesh(tmp_path / "a.ply", v, f, overwrite=False)
    with pytest.raises(FileNotFoundError):
        catamaran.read_mesh(tmp_path / "none.ply")
    (tmp_path / "bad.off").write_text("OFF\n1 1 0\n0 0 0\n3 0 1 2\n")
    with pytest.raises(OSError, match="bad.off"):
        catamaran.read_mesh(tmp_path / "bad.off")


def test_what_a_file_does_not_hold_is_a_warning(tmp_path):
    v, f = shapes.icosphere(2)
    far = v + [691608.37, 5334764.91, 519.25]
    with pytest.warns(UserWarning, match="a.stl: rounded coordinates .* move by up to 2"):
        catamaran.write_mesh(tmp_path / "a.stl", far, f)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        catamaran.write_mesh(tmp_path / "b.stl", far, f, text=True)
        w, g = catamaran.read_mesh(tmp_path / "b.stl")
    assert np.array_equal(w[g], far[f])
    with pytest.warns(UserWarning, match="c.stl: this format can't store colours"):
        catamaran.write_mesh(tmp_path / "c.stl", v, f, colors=v)
    with pytest.raises(OSError, match="320 of 320 faces vanish"):
        catamaran.write_mesh(tmp_path / "d.stl", 1e-3 * v + 1e6, f)
    assert not (tmp_path / "d.stl").exists()
    with pytest.raises(ValueError, match="text"):
        catamaran.write_mesh(tmp_path / "e.glb", v, f, text=True)
    (tmp_path / "f.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n")
    with pytest.warns(UserWarning, match="f.obj: left out lines"):
        catamaran.read_mesh(tmp_path / "f.obj")
    # Faces without texture coordinates come as they go.
    uv = np.random.default_rng(0).uniform(size=(len(f), 3, 2))
    uv[7] = np.nan
    catamaran.write_mesh(tmp_path / "g.obj", v, f, uv=uv)
    assert "nan" not in (tmp_path / "g.obj").read_text().lower()
    again = catamaran.read_mesh(tmp_path / "g.obj", attributes=True)[2]["uv"]
    assert np.array_equal(again, uv, equal_nan=True)
    uv[9, 1, 0] = np.nan
    with pytest.raises(ValueError, match="uv: face 9: NaN at some of its corners only"):
        catamaran.write_mesh(tmp_path / "h.obj", v, f, uv=uv)


def by_trimesh(path):
    mesh = pytest.importorskip("trimesh").load(path, process=False, force="mesh")
    return mesh.vertices, mesh.faces


def by_meshio(path):
    mesh = pytest.importorskip("meshio").read(path)
    # Those of OBJ have their colours behind them.
    return mesh.points[:, :3], mesh.cells_dict["triangle"]


def by_libigl(path):
    return igl.read_triangle_mesh(str(path))[:2]


def by_vtk(path):
    vtk = pytest.importorskip("vtk")
    numpy_support = pytest.importorskip("vtk.util.numpy_support")
    kinds = {"obj": "OBJ", "ply": "PLY", "stl": "STL", "off": "OFF", "glb": "GLTF"}
    reader = getattr(vtk, f"vtk{kinds[path.suffix[1:]]}Reader")()
    reader.SetFileName(str(path))
    if path.suffix == ".glb":
        flat = vtk.vtkCompositeDataGeometryFilter()
        flat.SetInputConnection(reader.GetOutputPort())
        reader = flat
    reader.Update()
    mesh = reader.GetOutput()
    faces = numpy_support.vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())
    return numpy_support.vtk_to_numpy(mesh.GetPoints().GetData()), faces.reshape(-1, 3)


def by_meshlab(path):
    meshes = pytest.importorskip("pymeshlab").MeshSet()
    meshes.load_new_mesh(str(path))
    meshes.apply_matrix_freeze()
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()


# scripts/test-python installs the first three.
@pytest.mark.parametrize("read", [by_trimesh, by_meshio, by_libigl, by_vtk, by_meshlab])
@pytest.mark.parametrize("kind", ["obj", "ply", "ply text", "stl", "stl text", "off", "glb"])
@pytest.mark.parametrize("with_uv", [False, True])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_other_programs_read_what_is_written(tmp_path, read, kind, with_uv):
    ending, *text = kind.split()
    if ending == "glb" and read in (by_meshio, by_libigl):
        pytest.skip("reads no glTF")
    if with_uv and read is by_meshio and ending in ("obj", "ply"):
        pytest.skip("reads no texture coordinates of corners")
    v, f = shapes.torus(12, 8)
    v = v + [1000, 2000, -500]
    path = tmp_path / f"a.{ending}"
    uv = None
    if with_uv:
        uv = np.random.default_rng(0).uniform(size=(len(f), 3, 2))
        # Two faces without texture coordinates.
        uv[5:7] = np.nan
    # VTK and meshio read OFF without colours only.
    plain = ending == "off" and read in (by_meshio, by_vtk)
    colors = None if plain else np.random.default_rng(0).uniform(size=(len(v), 3))
    catamaran.write_mesh(path, v, f, colors=colors, uv=uv, text=bool(text))
    theirs, faces = read(path)
    assert np.asarray(faces).shape == f.shape
    # Each of our faces is one of theirs: faces of glTF are ordered by what they have.
    ours, theirs = v[f].reshape(-1, 9), np.asarray(theirs)[faces].reshape(-1, 9)
    distances, numbers = scipy.spatial.cKDTree(theirs).query(ours)
    assert distances.max() < 5e-4 and len(np.unique(numbers)) == len(f)


def test_real_meshes_are_as_libigl_reads_them(tmp_path):
    packed = data("meshes/human_man.obj.gz")
    v, f = catamaran.read_mesh(packed)
    plain = tmp_path / "man.obj"
    plain.write_bytes(gzip.decompress(packed.read_bytes()))
    theirs = igl.read_triangle_mesh(str(plain))
    assert np.allclose(v, theirs[0]) and np.array_equal(f, theirs[1])
    values, vectors = catamaran.eigsh(v, f, 10)
    stiffness, mass, _ = catamaran.laplacian(v, f)
    residuals = stiffness @ vectors - mass @ vectors * values
    assert np.abs(residuals).max() < 1e-6 * values[-1] * np.abs(mass @ vectors).max()


def test_real_matrices_are_as_numpy_reads_them():
    path = data("meshes/armadillo43k.obj.gz")
    v, _ = catamaran.read_mesh(path)
    assert np.allclose(catamaran.cov(v), np.cov(v, rowvar=False), rtol=1e-10)
