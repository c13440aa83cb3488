"""Files of simulation, imaging and printing, from and to other programs."""

import zipfile

import numpy as np
import pytest

import catamaran
from catamaran import shapes


def surface(precision=float):
    """Vertices that have this precision, and faces."""
    v, f = shapes.torus(12, 8)
    return v.astype(precision).astype(float), f


def same(path, v, f, scalars=None, digits=0.0):
    """Reads a mesh, which must be this one up to `digits`, without a note."""
    again, faces, more = catamaran.read_mesh(path, attributes=True)
    assert np.allclose(again, v, rtol=0, atol=digits) and np.array_equal(faces, f)
    found = more.get("scalars", {})
    assert list(found) == list(scalars or {})
    for name, values in (scalars or {}).items():
        assert np.allclose(found[name], values, rtol=0, atol=digits), name
    assert more["notes"] == []


@pytest.mark.parametrize(
    "name, precision, options",
    [
        ("a.vtk", np.float64, {"file_format": "vtk51"}),
        ("a.vtk", np.float32, {"file_format": "vtk51"}),
        ("a.vtk", np.float64, {"file_format": "vtk51", "binary": False}),
        ("a.vtk", np.float64, {"file_format": "vtk42"}),
        ("a.vtk", np.float32, {"file_format": "vtk42"}),
        ("a.vtk", np.float64, {"file_format": "vtk42", "binary": False}),
        ("a.vtu", np.float64, {"compression": None}),
        ("a.vtu", np.float32, {"compression": None, "header_type": "UInt64"}),
        ("a.vtu", np.float64, {"compression": "zlib"}),
        ("a.vtu", np.float32, {"compression": "zlib", "header_type": "UInt64"}),
        ("a.vtu", np.float64, {"compression": "lzma"}),
        ("a.vtu", np.float64, {"binary": False}),
        ("a.msh", np.float64, {"file_format": "gmsh22"}),
        ("a.msh", np.float64, {"file_format": "gmsh22", "binary": False}),
        ("a.msh", np.float32, {"file_format": "gmsh22"}),
        ("a.msh", np.float64, {"file_format": "gmsh"}),
        ("a.msh", np.float64, {"file_format": "gmsh", "binary": False}),
    ],
)
def test_what_meshio_writes_is_read_and_ours_by_meshio(tmp_path, name, precision, options):
    meshio = pytest.importorskip("meshio")
    v, f = surface(precision)
    is_gmsh = name == "a.msh"
    # Gmsh has one type of values.
    number = np.arange(len(v), dtype=float if is_gmsh else np.int32)
    values = {"heat": np.linspace(0, 1, len(v)), "number": number}
    if is_gmsh and not options.get("binary", True):
        # meshio 5.3.5 writes values as "np.float64(0.5)" there, with numpy 2.
        values = {}
    mesh = meshio.Mesh(v.astype(precision), [("triangle", f)], point_data=values)
    mesh.write(tmp_path / name, **options)
    # Text has 12 digits.
    same(tmp_path / name, v, f, values, 1e-10)
    # meshio reads no PolyData of VTK.
    again, faces = catamaran.read_mesh(tmp_path / name)
    catamaran.write_mesh(tmp_path / "b.ply", again, faces)
    theirs = meshio.read(tmp_path / "b.ply")
    assert np.array_equal(theirs.points, again)
    assert np.array_equal(theirs.get_cells_type("triangle"), f)


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


@pytest.mark.parametrize(
    "mode, packing, word, is_big",
    [
        ("Ascii", "None", 32, False),
        ("Binary", "None", 32, True),
        ("Binary", "ZLib", 64, False),
        ("Binary", "LZMA", 64, True),
        ("Appended", "None", 64, False),
        ("Appended", "ZLib", 32, True),
        ("Appended", "LZ4", 32, False),
        ("Appended", "LZMA", 64, False),
    ],
)
@pytest.mark.parametrize("ending", ["vtp", "vtu"])
def test_what_vtk_writes_is_read_and_ours_by_vtk(tmp_path, ending, mode, packing, word, is_big):
    vtk = pytest.importorskip("vtk")
    support = pytest.importorskip("vtk.util.numpy_support")
    v, f = surface()
    heat = np.linspace(0, 1, len(v))
    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetData(support.numpy_to_vtk(v, deep=True))
    ends = support.numpy_to_vtkIdTypeArray(np.arange(0, 3 * len(f) + 1, 3), deep=True)
    corners = support.numpy_to_vtkIdTypeArray(f.astype(np.int64).ravel(), deep=True)
    cells.SetData(ends, corners)
    if ending == "vtp":
        data, writer = vtk.vtkPolyData(), vtk.vtkXMLPolyDataWriter()
        data.SetPolys(cells)
    else:
        data, writer = vtk.vtkUnstructuredGrid(), vtk.vtkXMLUnstructuredGridWriter()
        data.SetCells(vtk.VTK_TRIANGLE, cells)
    data.SetPoints(points)
    values = support.numpy_to_vtk(heat, deep=True)
    values.SetName("heat")
    data.GetPointData().AddArray(values)
    writer.SetFileName(str(tmp_path / f"a.{ending}"))
    writer.SetInputData(data)
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{packing}")()
    getattr(writer, f"SetHeaderTypeToUInt{word}")()
    (writer.SetByteOrderToBigEndian if is_big else writer.SetByteOrderToLittleEndian)()
    assert writer.Write() == 1
    same(tmp_path / f"a.{ending}", v, f, {"heat": heat}, 1e-10 if mode == "Ascii" else 0.0)
    again, faces = catamaran.read_mesh(tmp_path / f"a.{ending}")
    catamaran.write_mesh(tmp_path / "b.vtk", again, faces)
    read_by_vtk(tmp_path / "b.vtk", again, f)


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize(
    "version, binary, strips",
    [(42, False, False), (42, True, False), (51, False, False), (51, True, False), (51, True, True)],
)
def test_legacy_files_of_vtk_are_read_and_ours_by_vtk(tmp_path, version, binary, strips, text):
    vtk = pytest.importorskip("vtk")
    support = pytest.importorskip("vtk.util.numpy_support")
    v, f = surface()
    points, cells, mesh = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetData(support.numpy_to_vtk(v, deep=True))
    ends = support.numpy_to_vtkIdTypeArray(np.arange(0, 3 * len(f) + 1, 3), deep=True)
    cells.SetData(ends, support.numpy_to_vtkIdTypeArray(f.astype(np.int64).ravel(), deep=True))
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    heat = np.linspace(0, 1, len(v))
    values = support.numpy_to_vtk(heat, deep=True)
    values.SetName("heat")
    mesh.GetPointData().AddArray(values)
    if strips:
        stripper = vtk.vtkStripper()
        stripper.SetInputData(mesh)
        stripper.Update()
        mesh = stripper.GetOutput()
    writer = vtk.vtkPolyDataWriter()
    writer.SetFileName(str(tmp_path / "a.vtk"))
    writer.SetInputData(mesh)
    writer.SetFileVersion(version)
    (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
    assert writer.Write() == 1
    again, faces, more = catamaran.read_mesh(tmp_path / "a.vtk", attributes=True)
    # Text has 6 digits.
    digits = 0.0 if binary else 1e-5
    assert np.allclose(again, v, rtol=0, atol=digits) and more["notes"] == []
    assert np.allclose(more["scalars"]["heat"], heat, rtol=0, atol=digits)
    # Strips have the triangles in their own order.
    assert np.allclose(corners(again, rolled(faces)), corners(v, rolled(f)), atol=2 * digits)
    catamaran.write_mesh(tmp_path / "b.vtk", again, faces, text=text)
    read_by_vtk(tmp_path / "b.vtk", again, faces)


def read_by_vtk(path, v, f):
    """VTK reads this mesh."""
    vtk = pytest.importorskip("vtk")
    support = pytest.importorskip("vtk.util.numpy_support")
    reader = vtk.vtkPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    theirs = reader.GetOutput()
    assert np.array_equal(support.vtk_to_numpy(theirs.GetPoints().GetData()), v)
    connected = support.vtk_to_numpy(theirs.GetPolys().GetConnectivityArray())
    assert np.array_equal(connected.reshape(-1, 3), f)


def rolled(f):
    """Faces that begin with their lowest vertex."""
    f = np.asarray(f)
    turns = (np.arange(3) + f.argmin(axis=1)[:, None]) % 3
    return np.take_along_axis(f, turns, axis=1)


@pytest.mark.parametrize(
    "encoding, endian, ordering",
    [
        ("ASCII", "little", "C"),
        ("B64BIN", "little", "C"),
        ("B64BIN", "big", "C"),
        ("B64GZ", "little", "C"),
        ("B64GZ", "big", "F"),
    ],
)
def test_what_nibabel_writes_in_gifti_is_read_and_ours_by_nibabel(
    tmp_path, encoding, endian, ordering
):
    nibabel = pytest.importorskip("nibabel")
    v, f = surface(np.float32)
    heat = np.linspace(0, 1, len(v)).astype(np.float32)

    def array(values, intent, name):
        return nibabel.gifti.GiftiDataArray(
            values,
            intent=f"NIFTI_INTENT_{intent}",
            datatype="NIFTI_TYPE_INT32" if values.dtype.kind == "i" else "NIFTI_TYPE_FLOAT32",
            encoding=f"GIFTI_ENCODING_{encoding}",
            endian=endian,
            ordering=ordering,
            meta=nibabel.gifti.GiftiMetaData(Name=name),
        )

    arrays = [
        array(v.astype(np.float32), "POINTSET", "points"),
        array(f.astype(np.int32), "TRIANGLE", "faces"),
        array(heat, "SHAPE", "heat"),
    ]
    nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), tmp_path / "a.gii")
    # Text has 6 digits after the point.
    digits = 1e-6 if encoding == "ASCII" else 0.0
    same(tmp_path / "a.gii", v, f, {"heat": heat}, digits)
    nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays[2:]), tmp_path / "b.gii")
    values = catamaran.read_scalars(tmp_path / "b.gii")
    assert list(values) == ["heat"] and np.allclose(values["heat"], heat, rtol=0, atol=digits)
    again, faces = catamaran.read_mesh(tmp_path / "a.gii")
    catamaran.write_mesh(tmp_path / "c.gii", again.astype(np.float32), faces)
    theirs = nibabel.load(tmp_path / "c.gii")
    assert np.array_equal(theirs.agg_data("pointset"), again.astype(np.float32))
    assert np.array_equal(theirs.agg_data("triangle"), f)


@pytest.mark.parametrize(
    "name, options",
    [
        ("lh.white", {}),
        ("rh.pial", {"create_stamp": "created by a test"}),
        ("lh.inflated", {"create_stamp": ""}),
        ("lh.sphere", {"volume_info": True}),
        ("surface", {}),
    ],
)
@pytest.mark.filterwarnings("ignore:.*read as FreeSurfer:UserWarning")
def test_surfaces_of_freesurfer_are_read_and_ours_by_nibabel(tmp_path, name, options):
    nibabel = pytest.importorskip("nibabel")
    v, f = surface(np.float32)
    if "volume_info" in options:
        identity = dict(zip(("xras", "yras", "zras", "cras"), [*np.eye(3), np.zeros(3)]))
        about = {"head": [2, 0, 20], "valid": "1  # volume info valid", "filename": "a.mgz"}
        sizes = {"volume": [9, 9, 9], "voxelsize": np.ones(3)}
        options = {"volume_info": {**about, **sizes, **identity}}
    nibabel.freesurfer.write_geometry(tmp_path / name, v, f, **options)
    again, faces = catamaran.read_mesh(tmp_path / name)
    assert np.array_equal(again, v) and np.array_equal(faces, f)
    # FreeSurfer's own format is not written; its tools read GIFTI.
    catamaran.write_mesh(tmp_path / "b.gii", again.astype(np.float32), faces)
    theirs = nibabel.load(tmp_path / "b.gii")
    assert np.array_equal(theirs.agg_data("pointset"), v)
    assert np.array_equal(theirs.agg_data("triangle"), f)
    with pytest.raises(OSError, match="values of"):
        catamaran.read_scalars(tmp_path / name)


@pytest.mark.parametrize("name", ["lh.curv", "lh.thickness", "rh.sulc", "lh.area", "lh.area.pial"])
def test_values_of_freesurfer_are_read(tmp_path, name):
    nibabel = pytest.importorskip("nibabel")
    v, f = surface(np.float32)
    nibabel.freesurfer.write_morph_data(tmp_path / name, v[:, 0], len(f))
    values = catamaran.read_scalars(tmp_path / name)
    ending = name.rsplit(".", 1)[1]
    assert list(values) == [ending] and np.array_equal(values[ending], v[:, 0])


@pytest.mark.parametrize("name", ["lh.thickness.mgh", "lh.thickness.mgz"])
@pytest.mark.parametrize("kind", [np.float32, np.int32, np.int16, np.uint8])
@pytest.mark.parametrize("frames", [1, 3])
def test_values_of_mgh_are_read(tmp_path, name, kind, frames):
    nibabel = pytest.importorskip("nibabel")
    rng = np.random.default_rng(frames)
    values = (100 * rng.random((96, 1, 1, frames))).astype(kind)
    values = values if frames > 1 else values[..., 0]
    image = nibabel.freesurfer.MGHImage(values, np.eye(4))
    nibabel.save(image, tmp_path / name)
    found = catamaran.read_scalars(tmp_path / name)
    columns = values.reshape(96, frames)
    names = ["thickness"] if frames == 1 else [f"thickness.{k}" for k in range(frames)]
    assert list(found) == names
    for k, own in enumerate(names):
        assert np.array_equal(found[own], columns[:, k])


@pytest.mark.parametrize("labels, unknown", [(1, 0), (2, 3), (3, 0), (7, 5), (36, 100)])
def test_labels_of_freesurfer_are_read(tmp_path, labels, unknown):
    nibabel = pytest.importorskip("nibabel")
    rng = np.random.default_rng(labels)
    # Different colours, and transparency and a number for each.
    colors = np.zeros((labels, 5), dtype=np.int32)
    colors[:, 0], colors[:, 1] = np.arange(labels) + 1, rng.integers(0, 256, labels)
    numbers = rng.integers(0, labels, 100)
    numbers[:unknown] = -1
    names = [f"region {i}" for i in range(labels)]
    nibabel.freesurfer.write_annot(tmp_path / "lh.annot", numbers, colors, names, fill_ctab=True)
    values = catamaran.read_scalars(tmp_path / "lh.annot")
    assert list(values) == ["annot"] and np.array_equal(values["annot"], numbers)


def corners(v, f):
    """The corners of the faces, sorted: meshes of a scene come in any order."""
    rows = np.round(np.asarray(v)[np.asarray(f)].reshape(-1, 9), 6)
    return rows[np.lexsort(rows.T)]


@pytest.mark.parametrize("kind", ["packed", "stored", "two meshes", "moved", "one mesh twice"])
def test_what_trimesh_writes_in_3mf_is_read_and_ours_by_trimesh(tmp_path, kind):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    pytest.importorskip("lxml")
    v, f = surface()
    scene = trimesh.Scene()
    mesh = trimesh.Trimesh(v, f, process=False)
    scene.add_geometry(mesh, "first", "first")
    place = trimesh.transformations.translation_matrix([1, 2, 3])
    if kind == "two meshes":
        scene.add_geometry(trimesh.creation.box(), "second", "second")
    if kind == "moved":
        scene.graph.update("first", matrix=place @ np.diag([2, 3, 4, 1]))
    if kind == "one mesh twice":
        scene.graph.update("again", matrix=place, geometry="first")
    compression = zipfile.ZIP_STORED if kind == "stored" else zipfile.ZIP_DEFLATED
    written = trimesh.exchange.threemf.export_3MF(scene, compression=compression)
    (tmp_path / "a.3mf").write_bytes(written)
    again, faces = catamaran.read_mesh(tmp_path / "a.3mf")
    whole = scene.to_mesh()
    assert len(faces) == len(whole.faces)
    assert np.allclose(corners(again, faces), corners(whole.vertices, whole.faces), atol=1e-5)
    catamaran.write_mesh(tmp_path / "b.3mf", again, faces)
    theirs = trimesh.load(tmp_path / "b.3mf", process=False, force="mesh")
    assert np.array_equal(theirs.vertices, again) and np.array_equal(theirs.faces, faces)
