"""Files of simulation, imaging and printing, from and to other programs."""

import numpy as np
import pytest

import catamaran
from catamaran import shapes


@pytest.mark.parametrize(
    "name, options",
    [
        ("a.vtk", {"file_format": "vtk51"}),
        ("a.vtk", {"file_format": "vtk42"}),
        ("a.vtk", {"file_format": "vtk42", "binary": False}),
        ("a.vtu", {"compression": None}),
        ("a.vtu", {"compression": "zlib"}),
        ("a.vtu", {"binary": False}),
        ("a.msh", {"file_format": "gmsh22"}),
        ("a.msh", {"file_format": "gmsh"}),
    ],
)
def test_what_meshio_writes_is_read(tmp_path, name, options):
    meshio = pytest.importorskip("meshio")
    v, f = shapes.torus(12, 8)
    heat = np.linspace(0, 1, len(v))
    mesh = meshio.Mesh(v, [("triangle", f)], point_data={"heat": heat})
    mesh.write(tmp_path / name, **options)
    again, faces, more = catamaran.read_mesh(tmp_path / name, attributes=True)
    # Text has 12 digits.
    assert np.allclose(again, v, rtol=0, atol=1e-10) and np.array_equal(faces, f)
    assert np.allclose(more["scalars"]["heat"], heat, rtol=0, atol=1e-10)


def test_lines_are_left_out_with_a_warning(tmp_path):
    meshio = pytest.importorskip("meshio")
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0.0]])
    cells = [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 2]]), ("line", [[0, 1]])]
    # Of Gmsh 4.1, meshio writes one kind of cells.
    for name, kind in [("a.msh", "gmsh22"), ("a.vtk", "vtk"), ("a.vtu", "vtu")]:
        meshio.Mesh(points, cells).write(tmp_path / name, file_format=kind)
        with pytest.warns(UserWarning, match="left out cells that are not faces"):
            v, f = catamaran.read_mesh(tmp_path / name)
        assert np.array_equal(v, points) and len(f) == 3


def test_nibabel_reads_gifti_and_writes_it(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    v, f = shapes.icosphere(2)
    v = v.astype(np.float32).astype(float)
    catamaran.write_mesh(tmp_path / "a.gii", v, f)
    theirs = nibabel.load(tmp_path / "a.gii")
    assert np.array_equal(theirs.agg_data("pointset"), v)
    assert np.array_equal(theirs.agg_data("triangle"), f)
    nibabel.save(theirs, tmp_path / "b.gii")
    again, faces = catamaran.read_mesh(tmp_path / "b.gii")
    assert np.array_equal(again, v) and np.array_equal(faces, f)
    nibabel.freesurfer.write_geometry(tmp_path / "lh.white", v, f)
    again, faces = catamaran.read_mesh(tmp_path / "lh.white")
    assert np.array_equal(again, v) and np.array_equal(faces, f)
    nibabel.freesurfer.write_morph_data(tmp_path / "lh.thickness", v[:, 0], len(f))
    values = catamaran.read_scalars(tmp_path / "lh.thickness")
    assert list(values) == ["thickness"] and np.array_equal(values["thickness"], v[:, 0])
    with pytest.raises(OSError, match="no values of vertices"):
        catamaran.read_scalars(tmp_path / "a.gii")


@pytest.mark.parametrize("text", [False, True])
def test_vtk_reads_what_is_written(tmp_path, text):
    vtk = pytest.importorskip("vtk")
    numpy_support = pytest.importorskip("vtk.util.numpy_support")
    v, f = shapes.torus(12, 8)
    catamaran.write_mesh(tmp_path / "a.vtk", v, f, text=text)
    reader = vtk.vtkPolyDataReader()
    reader.SetFileName(str(tmp_path / "a.vtk"))
    reader.Update()
    mesh = reader.GetOutput()
    assert np.array_equal(numpy_support.vtk_to_numpy(mesh.GetPoints().GetData()), v)
    faces = numpy_support.vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())
    assert np.array_equal(faces.reshape(-1, 3), f)


def test_trimesh_reads_3mf(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    pytest.importorskip("lxml")
    v, f = shapes.torus(12, 8)
    catamaran.write_mesh(tmp_path / "a.3mf", v, f)
    theirs = trimesh.load(tmp_path / "a.3mf", process=False, force="mesh")
    assert np.allclose(theirs.vertices, v) and np.array_equal(theirs.faces, f)
