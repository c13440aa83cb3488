"""Readings of all mesh files of a folder beside those of other programs.

scripts/differential-meshes calls it and describes it.
"""

import argparse
import fnmatch
import gzip
import json
import lzma
import os
import re
import resource
import select
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections import Counter
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.sparse import coo_matrix  # noqa: E402
from scipy.sparse.csgraph import connected_components  # noqa: E402

# Formats of docs/guide/mesh-files.md and their endings.
FORMATS = {
    "OBJ": ("obj",),
    "PLY": ("ply",),
    "OFF": ("off",),
    "STL": ("stl",),
    "glTF": ("glb", "gltf"),
    "VTK": ("vtk",),
    "VTK XML": ("vtp", "vtu"),
    "GIFTI": ("gii",),
    "FreeSurfer": ("white", "pial", "inflated", "sphere", "orig"),
    "Gmsh": ("msh",),
    "3MF": ("3mf",),
}
OF_ENDING = {ending: name for name, endings in FORMATS.items() for ending in endings}
PACKED = ("gz", "xz", "zst", "zip")
# How much areas may differ, of the area, and volumes, of the sum of their absolute parts.
TOLERANCE = 1e-4
# How much volumes may differ by single precision, of the area times the largest coordinate.
SINGLE = 1e-6
GIB = 1 << 30


class Mesh(NamedTuple):
    """What a program reads: counts as it has them, and measures that no convention changes."""

    vertices: int
    faces: int
    places: int  # different positions in faces, in single precision
    triangles: int  # faces with three places
    components: int  # of the triangles, joined where they share a place
    area: float
    volume: float
    parts: float  # the sum of the volume's absolute parts
    largest: float  # coordinate in faces


class Refused(Exception):
    pass


def measure(positions, faces):
    positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
    if not len(faces):
        raise Refused("no faces")
    if faces.min() < 0 or faces.max() >= len(positions):
        raise Refused("a face has a vertex that is not there")
    used = positions[np.unique(faces)]
    if not np.isfinite(used).all():
        raise Refused("a position is not finite")
    corners = positions[faces] - (used.min(axis=0) + used.max(axis=0)) / 2
    edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(*edges), axis=1).sum() / 2
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    # 0 has one sign.
    rows = (positions.astype(np.float32) + np.float32(0))[faces.ravel()]
    rows = np.ascontiguousarray(rows).view("V12").ravel()
    places = np.unique(rows, return_inverse=True)[1].reshape(-1, 3)
    count = int(places.max()) + 1
    a, b, c = places.T
    places = places[(a != b) & (b != c) & (c != a)]
    if not len(places):
        raise Refused("no face with three places")
    ends = places[:, [0, 1]].T.ravel(), places[:, [1, 2]].T.ravel()
    graph = coo_matrix((np.ones(len(ends[0])), ends), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    components = len(np.unique(labels[places[:, 0]]))
    parts, largest = np.abs(volumes).sum(), float(np.abs(used).max())
    sizes = len(positions), len(faces), count, len(places), components
    return Mesh(*sizes, float(area), float(volumes.sum()), float(parts), largest)


def differences(one, other):
    """Returns the names of the measures in which two readings differ.

    A reader that moves the pieces of a file in single precision joins some places: of a thousand,
    one may differ, and one triangle if the numbers of faces are equal.
    """

    def far(name):
        a, b = getattr(one, name), getattr(other, name)
        return abs(a - b) * 1000 > max(a, b)

    names = ["places"] if far("places") else []
    if one.triangles != other.triangles and (one.faces != other.faces or far("triangles")):
        names.append("triangles")
    if one.components != other.components:
        names.append("components")
    if abs(one.area - other.area) > TOLERANCE * max(one.area, other.area):
        names.append("area")
    allowed = TOLERANCE * max(one.parts, other.parts) + SINGLE * one.area * one.largest
    if abs(one.volume - other.volume) > allowed:
        names.append("volume")
    return names


def fan(polygons):
    """Cuts polygons into triangles."""
    return [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]


def joined(pieces):
    """Puts the pieces of a file, as positions and faces, behind one another."""
    start, positions, faces = 0, [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)]
    for more, triangles in pieces:
        positions.append(np.asarray(more, dtype=np.float64).reshape(-1, 3))
        faces.append(np.asarray(triangles, dtype=np.int64).reshape(-1, 3) + start)
        start += len(positions[-1])
    return np.concatenate(positions), np.concatenate(faces)


def read_own_ply(path):
    """Reads the binary PLY that our program writes: all of its faces are triangles."""
    types = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2"}
    types |= {"int": "<i4", "uint": "<u4", "float": "<f4", "double": "<f8"}
    data = Path(path).read_bytes()
    at = data.index(b"end_header\n") + len(b"end_header\n")
    tables = {}
    elements = []
    for words in (line.split() for line in data[:at].decode().splitlines()):
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    for name, count, properties in elements:
        fields, offset = [], at
        for words in properties:
            if words[0] == "list":
                number = np.dtype(types[words[1]])
                length = int(np.frombuffer(data, number, 1, offset)[0]) if count else 0
                fields.append((f"number of {words[3]}", number))
                fields.append((words[3], types[words[2]], (length,)))
            else:
                fields.append((words[1], types[words[0]]))
            offset = at + np.dtype(fields).itemsize
        tables[name] = np.frombuffer(data, np.dtype(fields), count, at)
        at += tables[name].nbytes
    vertices = tables["vertex"]
    positions = np.stack([vertices[axis] for axis in "xyz"], axis=1)
    faces = tables["face"]
    indices = next((x for x in faces.dtype.names if x.startswith("vertex_ind")), None)
    return positions, faces[indices] if len(faces) else np.zeros((0, 3), np.int64)


def of_ours(program, path, seconds, memory):
    """Returns our reading, or why there is none, and the notes; `report` are lines that differ."""
    with tempfile.TemporaryDirectory() as folder:
        written = os.path.join(folder, "mesh.ply")
        command = [program, "mesh", path, "--json", "--quiet", "-o", written]
        limits = (int(memory * GIB), int(memory * GIB))
        try:
            run = subprocess.run(
                command,
                capture_output=True,
                timeout=seconds,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limits),
            )
        except subprocess.TimeoutExpired:
            return "time", []
        lines = run.stderr.decode(errors="replace").splitlines()
        notes = [line.removeprefix("note: ").replace(f"{path}: ", "") for line in lines
                 if line.startswith("note: ") and written not in line]
        if run.returncode < 0:
            return f"signal {-run.returncode}", notes
        if run.returncode:
            words = [line for line in lines if not line.startswith("note: ")]
            return " ".join(words).replace(f"{path}:", "").removeprefix("catamaran: "), notes
        try:
            mesh = measure(*read_own_ply(written))
        except Refused as why:
            return str(why), notes
        records = {}
        for line in run.stdout.decode().splitlines():
            records[json.loads(line)["record"]] = json.loads(line)
    told = records["validation"]
    pairs = [("vertices", told["vertices"], mesh.vertices), ("faces", told["faces"], mesh.faces)]
    pairs.append(("area", records["area"]["area"], mesh.area))
    if "volume" in records:
        pairs.append(("volume", records["volume"]["volume"], mesh.volume))
    for name, of_report, of_file in pairs:
        if abs(of_report - of_file) > 1e-7 * max(abs(of_report), mesh.parts * (name == "volume")):
            notes.append(f"REPORT: {name} {of_report}, but {of_file} of what it writes")
    return mesh, notes


# Each reader of another program takes a path, its format and its ending in lower case without
# that of packing, and returns positions and triangles.


def with_trimesh():
    import trimesh

    def read(path, _, ending):
        scene = trimesh.load_scene(path, file_type=ending, process=False)
        pieces = []
        for node in scene.graph.nodes_geometry:
            transform, name = scene.graph[node]
            piece = scene.geometry[name]
            if isinstance(piece, trimesh.Trimesh):
                positions = trimesh.transform_points(piece.vertices, transform)
                pieces.append((positions, piece.faces))
        return joined(pieces)

    return trimesh.__version__, [f for f in FORMATS if f not in ("GIFTI", "FreeSurfer")], read


def with_meshio():
    import meshio

    names = {"OBJ": "obj", "PLY": "ply", "OFF": "off", "STL": "stl", "VTK": "vtk", "Gmsh": "gmsh"}

    def read(path, form, ending):
        if ending == "vtp":
            raise Refused("not a format of meshio")
        mesh = meshio.read(path, file_format=names.get(form, "vtu"))
        faces = []
        for block in mesh.cells:
            corners = re.fullmatch(r"(triangle|quad)\d*", block.type)
            if corners:
                faces += fan(block.data[:, : 3 if corners[1] == "triangle" else 4].tolist())
            elif block.type == "polygon":
                faces += fan(block.data)
        positions = np.zeros((len(mesh.points), 3))
        width = min(3, mesh.points.shape[1]) if len(mesh.points) else 0
        positions[:, :width] = mesh.points[:, :width]
        return positions, faces

    return meshio.__version__, [*names, "VTK XML"], read


def with_vtk():
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    readers = {
        "obj": vtk.vtkOBJReader,
        "ply": vtk.vtkPLYReader,
        "off": getattr(vtk, "vtkOFFReader", None),
        "stl": vtk.vtkSTLReader,
        "glb": vtk.vtkGLTFReader,
        "gltf": vtk.vtkGLTFReader,
        "vtk": vtk.vtkGenericDataObjectReader,
        "vtp": vtk.vtkXMLPolyDataReader,
        "vtu": vtk.vtkXMLUnstructuredGridReader,
    }

    def cut(data, i, ids):
        """Returns the triangles of a cell, of none that is not a surface."""
        kind = data.GetCellType(i)
        if kind == vtk.VTK_TRIANGLE:
            return [tuple(ids)]
        if kind == vtk.VTK_PIXEL:
            return fan([[ids[0], ids[1], ids[3], ids[2]]])
        if kind == vtk.VTK_TRIANGLE_STRIP:
            turned = [(k, k + 1, k + 2) if k % 2 == 0 else (k + 1, k, k + 2)
                      for k in range(len(ids) - 2)]
            return [tuple(ids[k] for k in each) for each in turned]
        cell = data.GetCell(i)
        if cell.GetCellDimension() != 2:
            return []
        if not cell.IsLinear():
            # Curved: the corners come first, and ours takes them alone.
            return fan([ids[: cell.GetNumberOfEdges()]])
        found = vtk.vtkIdList()
        if not cell.TriangulateIds(0, found) or not found.GetNumberOfIds():
            return fan([ids])
        flat = [found.GetId(k) for k in range(found.GetNumberOfIds())]
        return list(zip(flat[::3], flat[1::3], flat[2::3], strict=True))

    def pieces(data):
        if isinstance(data, vtk.vtkCompositeDataSet):
            iterator = data.NewIterator()
            while not iterator.IsDoneWithTraversal():
                yield from pieces(iterator.GetCurrentDataObject())
                iterator.GoToNextItem()
        elif isinstance(data, vtk.vtkPointSet) and data.GetNumberOfPoints():
            faces, corners = [], vtk.vtkIdList()
            for i in range(data.GetNumberOfCells()):
                data.GetCellPoints(i, corners)
                ids = [corners.GetId(k) for k in range(corners.GetNumberOfIds())]
                faces += cut(data, i, ids)
            yield vtk_to_numpy(data.GetPoints().GetData()), faces

    def read(path, _, ending):
        if readers.get(ending) is None:
            raise Refused("not a format of this version of VTK")
        reader = readers[ending]()
        errors = []
        reader.AddObserver("ErrorEvent", lambda *_: errors.append(1))
        reader.SetFileName(path)
        reader.Update()
        if errors:
            raise Refused("an error")
        return joined(pieces(reader.GetOutputDataObject(0)))

    vtk.vtkObject.GlobalWarningDisplayOff()
    version = vtk.vtkVersion.GetVTKVersion()
    return version, ["OBJ", "PLY", "OFF", "STL", "glTF", "VTK", "VTK XML"], read


def with_pymeshlab():
    import pymeshlab

    def read(path, *_):
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(path)
        pieces = []
        for mesh in meshes:
            positions = mesh.transformed_vertex_matrix()
            pieces.append((positions, mesh.face_matrix()))
        return joined(pieces)

    version = pymeshlab.__version__ if hasattr(pymeshlab, "__version__") else ""
    return version, ["OBJ", "PLY", "OFF", "STL", "glTF", "3MF"], read


def with_nibabel():
    import nibabel

    def read(path, form, _):
        if form == "FreeSurfer":
            return nibabel.freesurfer.read_geometry(path)[:2]
        image = nibabel.load(path)
        positions = image.agg_data("NIFTI_INTENT_POINTSET")
        return positions, image.agg_data("NIFTI_INTENT_TRIANGLE")

    return nibabel.__version__, ["GIFTI", "FreeSurfer"], read


OTHERS = {
    "trimesh": with_trimesh,
    "meshio": with_meshio,
    "vtk": with_vtk,
    "pymeshlab": with_pymeshlab,
    "nibabel": with_nibabel,
}


def apart(read, arguments, seconds, memory):
    """Reads in a process of its own, which shares what this one has imported."""
    out, into = os.pipe()
    child = os.fork()
    if not child:
        try:
            silent = os.open(os.devnull, os.O_RDWR)
            for each in (0, 1, 2):
                os.dup2(silent, each)
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            most = pages * resource.getpagesize() + int(memory * GIB)
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            try:
                answer = list(measure(*read(*arguments)))
            except MemoryError:
                answer = "memory"
            except BaseException as why:
                answer = " ".join(f"{type(why).__name__}: {why}".split())[:200]
            os.write(into, json.dumps(answer).encode())
        finally:
            os._exit(0)
    os.close(into)
    end, data = time.monotonic() + seconds, b""
    while True:
        if not select.select([out], [], [], max(0, end - time.monotonic()))[0]:
            os.kill(child, signal.SIGKILL)
            data = b'"time"'
            break
        part = os.read(out, 1 << 16)
        if not part:
            break
        data += part
    os.close(out)
    status = os.waitpid(child, 0)[1]
    if not data:
        return f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "no answer"
    answer = json.loads(data)
    return answer if isinstance(answer, str) else Mesh(*answer)


def endings(path):
    """Returns the ending in lower case without that of packing, and whether there is one."""
    words = path.name.lower().split(".")
    packed = len(words) > 1 and words[-1] in PACKED
    words = words[: len(words) - packed]
    return words[-1] if len(words) > 1 else "", packed


def unpack(path, folder):
    """Unpacks a file into a folder for programs that don't; `None` where that can't be done."""
    packing = path.suffix.lower()
    try:
        if packing == ".zip":
            with zipfile.ZipFile(path) as archive:
                name, data = archive.namelist()[0], archive.read(archive.namelist()[0])
        elif packing in (".gz", ".xz"):
            name = path.stem
            with (gzip if packing == ".gz" else lzma).open(path) as file:
                data = file.read()
        else:
            return None
    except (OSError, EOFError, IndexError, lzma.LZMAError, zipfile.BadZipFile):
        return None
    unpacked = Path(folder, Path(name).name)
    unpacked.write_bytes(data)
    return unpacked


def by_content(path):
    """Returns the format that the first bytes of a file show without a doubt."""
    with path.open("rb") as file:
        head = file.read(4096)
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    if head[:4] == b"glTF":
        return "glTF"
    if text[:3] == b"ply" and text[3:4] in (b"\r", b"\n"):
        return "PLY"
    if re.match(rb"(ST)?(C)?(N)?(4)?(n)?OFF\s", text):
        return "OFF"
    if text[:5].lower() == b"solid" and b"facet" in text.lower():
        return "STL"
    if text[:14] == b"# vtk DataFile":
        return "VTK"
    if b"<VTKFile" in text and re.search(rb'type="(PolyData|UnstructuredGrid)"', text):
        return "VTK XML"
    if b"<GIFTI" in text:
        return "GIFTI"
    if head[:3] == b"\xff\xff\xfe":
        return "FreeSurfer"
    if text[:11] == b"$MeshFormat":
        return "Gmsh"
    if head[:2] == b"PK" and b"3D/3dmodel" in head:
        return "3MF"
    return None


def mesh_files(folder):
    """Yields path, format, ending and whether it is packed of the mesh files of a folder."""
    for top, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            path = Path(top, name)
            if not path.is_file() or path.is_symlink():
                continue
            ending, packed = endings(path)
            form = OF_ENDING.get(ending)
            if not packed:
                form = by_content(path) or form
            if form:
                suits = ending in FORMATS[form]
                yield path, form, ending if suits else FORMATS[form][0], packed


def listed(path):
    """Reads patterns of paths and reasons: a line each, blanks between."""
    lines = Path(path).read_text().splitlines()
    pairs = (line.split(None, 1) for line in lines if line.strip() and line[0] != "#")
    return [(pattern, reason) for pattern, reason in pairs]


def shown(mesh):
    if isinstance(mesh, str):
        return mesh[:160]
    return (
        f"{mesh.vertices} vertices ({mesh.places} places), {mesh.faces} faces "
        f"({mesh.triangles} triangles), {mesh.components} components, "
        f"area {mesh.area:.9g}, volume {mesh.volume:.9g}"
    )


def main():
    parser = argparse.ArgumentParser(prog="differential-meshes", usage="see --help of the script")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default="target/release/catamaran")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--memory", type=float, default=4)
    parser.add_argument("--known", default="scripts/differential-meshes.txt")
    parser.add_argument("--json", dest="record")
    options = parser.parse_args()
    known = listed(options.known)
    others = {}
    for name, load in OTHERS.items():
        try:
            others[name] = load()
        except ImportError as why:
            print(f"without {name}: {why}")
    print("beside", ", ".join(f"{name} {x[0]}".strip() for name, x in others.items()))

    names = ["ours", *others]
    record, faults, excused = [], 0, 0
    tally = Counter()
    for path, form, ending, packed in mesh_files(options.folder):
        limits = options.seconds, options.memory
        ours, notes = of_ours(options.program, str(path), *limits)
        found = {"ours": ours}
        with tempfile.TemporaryDirectory() as temporary:
            plain = unpack(path, temporary) if packed else path
            for name, (_, forms, read) in others.items():
                if form in forms and plain:
                    found[name] = apart(read, (str(plain), form, ending), *limits)
        short = str(path.relative_to(options.folder))
        readings = {name: x for name, x in found.items() if isinstance(x, Mesh)}
        for each in form, "all":
            tally[each, "files"] += 1
            tally[each, "any"] += bool(readings)
            tally[each, "any other"] += bool(readings.keys() - {"ours"})
            tally[each, "missing"] += bool(readings) and "ours" not in readings
            for name in found:
                tally[each, name, "asked"] += 1
                tally[each, name, "read"] += name in readings
        apart_from = []
        if "ours" in readings:
            for name, mesh in readings.items():
                words = differences(ours, mesh)
                if words:
                    apart_from.append(f"{name} ({', '.join(words)})")
        wrong = [note for note in notes if note.startswith("REPORT")]
        lines = []
        if readings and "ours" not in readings:
            reasons = [why for pattern, why in known if fnmatch.fnmatch(str(path), f"*{pattern}")]
            excused += bool(reasons)
            faults += not reasons
            lines.append("NOT READ" + (f", known: {reasons[0]}" if reasons else ""))
        if apart_from:
            tally[form, "apart"] += 1
            tally["all", "apart"] += 1
            lines.append("DIFFERS from " + ", ".join(apart_from))
        if wrong or str(ours).startswith(("time", "signal")):
            lines.append("OURS: " + "; ".join(wrong or [ours]))
        if lines:
            print(f"\n{short} ({form}): {'; '.join(lines)}")
            for name, mesh in found.items():
                print(f"  {name}: {shown(mesh)}")
            for note in notes:
                print(f"  note: {note}")
            sys.stdout.flush()
        answers = {n: x if isinstance(x, str) else x._asdict() for n, x in found.items()}
        line = {"path": short, "format": form, "notes": notes, "apart": apart_from}
        record.append(line | {"found": answers})

    print("\nread / refused, for each format; a dash: not a format of that program")
    head = ["format", "files", *names, "by any other", "ours not", "differ"]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for form in [*FORMATS, "all"]:
        if not tally[form, "files"]:
            continue
        cells = [form, tally[form, "files"]]
        for name in names:
            asked, read = tally[form, name, "asked"], tally[form, name, "read"]
            cells.append(f"{read} / {asked - read}" if asked else "-")
        cells += [tally[form, "any other"], tally[form, "missing"], tally[form, "apart"]]
        print("| " + " | ".join(map(str, cells)) + " |")
    share = 100 * (1 - tally["all", "missing"] / max(1, tally["all", "any"]))
    print(f"\nread by any: {tally['all', 'any']}; of these read by ours: {share:.2f} %")
    print(f"not read by ours without a reason: {faults}; with a reason: {excused}")
    if options.record:
        Path(options.record).write_text("".join(json.dumps(x) + "\n" for x in record))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
