"""Seconds to read a mesh of a million triangles, beside other programs.

    python bench/rivals/mesh_readers.py --program target/release/catamaran > record.md

A torus of 1000 x 500 places is written in each format by numpy, trimesh or meshio, and read by
`catamaran mesh`, which tells how long its reader took, and by trimesh, meshio, VTK and pymeshlab,
those that are installed, in this process. A file is read once before it is measured. `--program`
may be given several times. Run it on one core (`taskset -c 0`): all of these readers use one.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402

# Places around and across the torus.
AROUND, ACROSS = 1000, 500


def torus():
    """Returns positions and triangles, two for each place."""
    u, v = np.meshgrid(np.arange(AROUND), np.arange(ACROSS), indexing="ij")
    a, b = 2 * np.pi * u / AROUND, 2 * np.pi * v / ACROSS
    r = 2 + np.cos(b)
    positions = np.stack([r * np.cos(a), r * np.sin(a), np.sin(b)], axis=-1).reshape(-1, 3)
    next_u, next_v = (u + 1) % AROUND, (v + 1) % ACROSS
    p, q = u * ACROSS + v, next_u * ACROSS + v
    s, t = next_u * ACROSS + next_v, u * ACROSS + next_v
    faces = np.stack([np.stack([p, q, s], -1), np.stack([p, s, t], -1)], axis=2)
    return positions.astype(np.float32).astype(float), faces.reshape(-1, 3).astype(np.int32)


def lines(path, head, *tables):
    """Writes a text: a head, and tables with the format of their rows."""
    with open(path, "w") as file:
        file.write(head)
        for form, rows in tables:
            np.savetxt(file, rows, form)


def write(folder):
    """Writes the files; returns the path of each and the names of the others that read it."""
    import meshio
    import trimesh

    v, f = torus()
    threes = np.column_stack([np.full(len(f), 3), f])
    mesh = trimesh.Trimesh(v, f, process=False)
    everyone = ["trimesh", "meshio", "VTK", "pymeshlab"]
    files = {}

    def add(label, name, rivals=everyone):
        files[label] = (folder / name, rivals)
        return folder / name

    vertices, faces = ("v %.9g %.9g %.9g", v), ("f %d %d %d", f + 1)
    lines(add("OBJ", "a.obj"), "", vertices, faces)
    ply = "".join(f"property float {axis}\n" for axis in "xyz")
    ply = f"element vertex {len(v)}\n{ply}element face {len(f)}\n"
    ply += "property list uchar int vertex_indices\nend_header\n"
    head = f"ply\nformat ascii 1.0\n{ply}"
    lines(add("PLY, text", "t.ply"), head, ("%.9g %.9g %.9g", v), ("%d %d %d %d", threes))
    add("PLY, binary", "b.ply").write_bytes(trimesh.exchange.ply.export_ply(mesh))
    head = f"OFF\n{len(v)} {len(f)} 0\n"
    lines(add("OFF", "a.off"), head, ("%.9g %.9g %.9g", v), ("%d %d %d %d", threes))
    add("STL, binary", "b.stl").write_bytes(trimesh.exchange.stl.export_stl(mesh))
    add("STL, text", "t.stl").write_text(trimesh.exchange.stl.export_stl_ascii(mesh))
    glb = trimesh.exchange.gltf.export_glb(mesh.scene())
    add("glTF, binary", "a.glb", ["trimesh", "VTK", "pymeshlab"]).write_bytes(glb)
    for label, name, binary in (("VTK, binary", "b.vtk", True), ("VTK, text", "t.vtk", False)):
        cells = meshio.Mesh(v.astype(np.float32), [("triangle", f)])
        path = add(label, name, ["meshio", "VTK"])
        cells.write(path, file_format="vtk42", binary=binary)
    return len(f), files


def with_trimesh():
    import trimesh

    def read(path):
        mesh = trimesh.load(path, process=False, force="mesh")
        return len(mesh.faces)

    return trimesh.__version__, read


def with_meshio():
    import meshio

    def read(path):
        return sum(len(block.data) for block in meshio.read(path).cells)

    return meshio.__version__, read


def with_vtk():
    import vtk

    readers = {
        ".obj": vtk.vtkOBJReader,
        ".ply": vtk.vtkPLYReader,
        ".off": getattr(vtk, "vtkOFFReader", None),
        ".stl": vtk.vtkSTLReader,
        ".glb": vtk.vtkGLTFReader,
        ".vtk": vtk.vtkGenericDataObjectReader,
    }

    def read(path):
        reader = readers[path.suffix]()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutputDataObject(0)
        return data.GetNumberOfElements(vtk.vtkDataObject.CELL)

    return vtk.vtkVersion.GetVTKVersion(), read


def with_pymeshlab():
    import pymeshlab

    def read(path):
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(path))
        return meshes.current_mesh().face_number()

    return getattr(pymeshlab, "__version__", ""), read


OTHERS = {
    "trimesh": with_trimesh,
    "meshio": with_meshio,
    "VTK": with_vtk,
    "pymeshlab": with_pymeshlab,
}


def of_program(program, path):
    """Returns the seconds of our reader, and the number of faces."""
    command = [program, "mesh", str(path), "--json"]
    run = subprocess.run(command, capture_output=True, check=True, text=True)
    records = {}
    for line in run.stdout.splitlines():
        record = json.loads(line)
        records.setdefault(record["record"], record)
    return records["mesh"]["seconds"], records["validation"]["faces"]


def of_other(read, path):
    start = time.perf_counter()
    faces = read(path)
    return time.perf_counter() - start, faces


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", action="append", required=True)
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--only", default="", help="part of the names of the formats to measure")
    options = parser.parse_args()
    others = {}
    for name, load in OTHERS.items():
        try:
            others[name] = load()
        except ImportError as why:
            print(f"without {name}: {why}", file=sys.stderr)
    names = [Path(program).parts[-4] if len(options.program) > 1 else "ours"
             for program in options.program]
    versions = ", ".join(f"{name} {x[0]}".strip() for name, x in others.items())
    print(f"{platform.machine()}, load {os.getloadavg()[0]:.1f}; {versions}\n")
    print("| Format | MB | " + " | ".join([*names, *others]) + " | best other / ours |")
    print("|" + "---|" * (len(names) + len(others) + 3))
    with tempfile.TemporaryDirectory() as folder:
        count, files = write(Path(folder))
        for label, (path, rivals) in files.items():
            if options.only not in label:
                continue
            readers = {name: (of_program, program)
                       for name, program in zip(names, options.program, strict=True)}
            readers |= {name: (of_other, others[name][1]) for name in rivals if name in others}
            seconds = {name: [] for name in readers}
            for turn in range(options.repetitions + 1):
                for name, (measure, by) in list(readers.items()):
                    try:
                        time_taken, faces = measure(by, path)
                    except Exception as why:
                        print(f"{label}, {name}: {why}", file=sys.stderr)
                        faces = 0
                    if faces != count:
                        del readers[name], seconds[name]
                    elif turn > 0:
                        seconds[name].append(time_taken)
            medians = {name: statistics.median(x) for name, x in seconds.items()}
            best = min((medians[name] for name in others if name in medians), default=float("nan"))
            cells = [f"{medians[name]:.3f}" if name in medians else "-"
                     for name in [*names, *others]]
            size = path.stat().st_size / 1e6
            ratio = best / medians.get(names[0], float("nan"))
            print(f"| {label} | {size:.0f} | " + " | ".join(cells) + f" | {ratio:.1f} |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
