"""Meshes: files, Laplacians and their spectra."""

from __future__ import annotations

import os
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import (
    Path,
    Progress,
    callback,
    csr,
    is_sparse,
    mass_of,
    matrix_of,
    to_scipy,
    warn_caller,
    warn_of_pieces,
)
from ._show import axes
from ._surface import Mesh, MeshLike, mesh_arrays, takes_mesh, with_mesh
from ._words import Boundary, Kind, MassKind, MeshFormat

__all__ = [
    "Eigenpairs",
    "Laplacian",
    "cloud_laplacian",
    "count_below",
    "dirichlet_energies",
    "divergence",
    "eigsh",
    "free_components",
    "gradient",
    "laplacian",
    "mesh_from_bytes",
    "mesh_to_bytes",
    "read_mesh",
    "read_scalars",
    "write_mesh",
]


def read_mesh(path: Path, *, attributes: bool = False) -> Any:
    """Reads a mesh, in a format of docs/guide/mesh-files.md, also packed (.gz, .xz, .bz2, .zst,
    .zip).

    Parameters
    ----------
    path : path
        The file.
    attributes : bool
        Whether what else is in the file is returned, too.

    Returns
    -------
    v : ndarray, n x 3
        Vertices.
    f : ndarray, m x 3
        Faces.
    more : dict
        With `attributes`, what there is of: "uv" (m x 3 x 2, for the corners of faces), "normals"
        (m x 3 x 3), "colors" (n x 4), "scalars" (a dict of names and n values each), "materials",
        "groups" and "objects" (names, and the number of one for each face), and "notes", a list of
        what was repaired or left out.

    Warns
    -----
    UserWarning
        For each note.

    Raises
    ------
    OSError
        Names the file, the line, and what is wrong with it.

    Examples
    --------
    >>> import os, tempfile
    >>> import catamaran
    >>> v, f = catamaran.shapes.icosphere(1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "sphere.ply")
    ...     catamaran.write_mesh(path, v, f)
    ...     again = catamaran.read_mesh(path)
    >>> bool((again[1] == f).all())
    True
    """
    v, f, more = _catamaran.read_mesh(path)
    warn(path, more["notes"])
    return (v, f, more) if attributes else Mesh(v, f)


def shares(colors: Any) -> Any:
    """Returns colours from 0 to 1, of bytes too."""
    given = None if colors is None else matrix_of("colors", colors)
    return given / 255 if given is not None and given.dtype == np.uint8 else given


def read_scalars(path: Path) -> Dict[str, NDArray[np.float64]]:
    """Reads values of vertices: of a mesh, of GIFTI without a surface, or of FreeSurfer.

    Parameters
    ----------
    path : path
        The file, such as `lh.thickness`, `lh.annot` or `lh.sulc.mgz`, or a mesh with values.

    Returns
    -------
    dict of str and ndarray
        The values of the vertices by their names; NaN where there is none. Of `.annot`, the numbers
        of labels, -1 for none. Several frames of MGH have their numbers, from 0, after the name.

    Raises
    ------
    OSError
        Names the file, the line, and what is wrong with it.

    Examples
    --------
    >>> import os, struct, tempfile
    >>> import catamaran
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "lh.thickness")
    ...     with open(path, "wb") as file:
    ...         _ = file.write(b"\\xff" * 3 + struct.pack(">3i2f", 2, 0, 1, 2.5, 3.0))
    ...     values = catamaran.read_scalars(path)
    >>> values["thickness"].tolist()
    [2.5, 3.0]
    """
    return _catamaran.read_scalars(path)


def write_mesh(
    path: Path,
    v: Union[ArrayLike, MeshLike],
    f: Optional[ArrayLike] = None,
    *,
    colors: Optional[ArrayLike] = None,
    uv: Optional[ArrayLike] = None,
    overwrite: bool = True,
    text: bool = False,
) -> None:
    """Writes a mesh in the format that the name says, as `read_mesh` reads it.

    Parameters
    ----------
    path : path
        The file; it appears whole or not at all.
    v, f : array_like, n x 3 and m x 3
        Vertices and faces; or a mesh instead of both.
    colors : array_like, n x 3 or n x 4, optional
        Colours of the vertices, from 0 to 1; those of uint8, as trimesh has them, from 0 to 255.
    uv : array_like, m x 3 x 2, optional
        Texture coordinates of the corners of faces, NaN where a face has none.
    overwrite : bool
        Whether a file that is there is replaced.
    text : bool
        Whether .stl, .ply and .vtk are text with every digit. Binary .stl, .gii and glTF have
        single precision.

    Warns
    -----
    UserWarning
        Names what the format can't store, and the largest distance by which single precision moves
        a vertex.

    Raises
    ------
    OSError
        Names the file; also where faces would vanish in single precision.
    """
    mesh: Any = (v, f) if f is not None else mesh_arrays(v)
    if mesh is None:
        raise TypeError("f: missing, and v is not a mesh")
    if uv is not None:
        uv = np.asarray(matrix_of("uv", uv), dtype=np.float64)
    warn(path, _catamaran.write_mesh(path, mesh[0], mesh[1], shares(colors), uv, overwrite, text))


def mesh_from_bytes(data: bytes, format: MeshFormat, *, attributes: bool = False) -> Any:
    """Reads a mesh file that is in memory, not packed, as `read_mesh` reads one on disk.

    Parameters
    ----------
    data : bytes
        The content of the file.
    format : str
        Its format, by the ending of its files: "obj", "ply", "off", "stl", "glb", "gltf", "vtk",
        "vtp", "vtu", "gii", "white" (surfaces of FreeSurfer), "msh" or "3mf".
    attributes : bool
        As in `read_mesh`, as are the results, warnings and errors.

    Examples
    --------
    >>> import catamaran
    >>> v, f = catamaran.mesh_from_bytes(b"v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n", "obj")
    >>> f
    array([[0, 1, 2]])
    """
    v, f, more = _catamaran.mesh_from_bytes(data, format)
    warn(f"mesh.{format}", more["notes"])
    return (v, f, more) if attributes else Mesh(v, f)


@takes_mesh
def mesh_to_bytes(
    v: ArrayLike,
    f: ArrayLike,
    format: MeshFormat,
    *,
    colors: Optional[ArrayLike] = None,
    uv: Optional[ArrayLike] = None,
    text: bool = False,
) -> bytes:
    """Returns the content of a mesh file, as `write_mesh` writes it.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    format : {"obj", "ply", "off", "stl", "glb", "gltf", "vtk", "gii", "3mf"}
        The format.
    colors, uv, text
        As in `write_mesh`, as are warnings and errors.

    Examples
    --------
    >>> import catamaran
    >>> catamaran.mesh_to_bytes(catamaran.shapes.grid(1, 1), "off")[:8]
    b'OFF\\n4 2 '
    """
    if uv is not None:
        uv = np.asarray(matrix_of("uv", uv), dtype=np.float64)
    data, notes = _catamaran.mesh_to_bytes(v, f, format, shares(colors), uv, text)
    warn(f"mesh.{format}", notes)
    return data


def warn(path: Path, notes: Sequence[str]) -> None:
    """Turns notes about a file into warnings at the line that called this package."""
    for note in notes:
        warn_caller(f"{os.fspath(path)}: {note}")


class Laplacian(NamedTuple):
    """Matrices of the eigenproblem ``stiffness @ phi = value * mass @ phi``."""

    #: Positive semi-definite, as a `scipy.sparse.csr_array`. It is minus `igl.cotmatrix`.
    stiffness: Any
    #: Positive definite; the entries sum to the area.
    mass: Any
    #: The vertices that rows stand for.
    kept: NDArray[Any]


@takes_mesh
def laplacian(
    v: ArrayLike,
    f: ArrayLike,
    *,
    kind: Kind = "cotangent",
    mass: MassKind = "barycentric",
    boundary: Union[Boundary, ArrayLike] = "neumann",
    weld: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Laplacian:
    """Assembles the Laplacian of a mesh as matrices of scipy.sparse.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    kind : {"cotangent", "intrinsic", "tufted"}
        Triangles of the mesh, of its intrinsic Delaunay triangulation, or of that of the tufted
        cover, for meshes with edges of many faces or faces without area.
    mass : {"barycentric", "voronoi", "full"}
        The mass matrix, called as in `igl.massmatrix`.
    boundary : {"neumann", "dirichlet"} or array_like of vertices
        Natural boundary values, zero at the boundary, or zero at these vertices. Rows of vertices
        with value zero are left out.
    weld : bool
        Whether vertices with equal positions are joined, as along the seams of a texture. Only the
        first of them has a row.
    threads, progress
        As in `ata`.

    Returns
    -------
    Laplacian
        ``stiffness``, ``mass``, ``kept``.

    Examples
    --------
    >>> import catamaran
    >>> stiffness, mass, kept = catamaran.laplacian(*catamaran.shapes.icosphere(3))
    >>> float(round(mass.sum(), 2))  # about 4 pi
    12.51
    """
    stiffness, masses, kept = _catamaran.laplacian(
        v, f, kind, mass, boundary, weld, threads, callback(progress)
    )
    return Laplacian(to_scipy(stiffness), to_scipy(masses), kept)


def cloud_laplacian(
    points: ArrayLike,
    *,
    neighbours: int = 30,
    boundary: Union[Boundary, ArrayLike] = "neumann",
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Laplacian:
    """Assembles the Laplacian of the surface that points were sampled from.

    Around each point its nearest ones are triangulated in the plane that fits them; the result is
    the tufted Laplacian of all these triangles (Sharp and Crane 2020).

    Parameters
    ----------
    points : array_like, n x 3
        The points, no two of them in one place.
    neighbours : int
        Nearest points with which each one is triangulated, at least 3.
    boundary : {"neumann", "dirichlet"} or array_like of points
        As in `laplacian`; at the boundary are the points around which triangles leave a gap.
    threads, progress
        As in `ata`.

    Returns
    -------
    Laplacian
        ``stiffness``, ``mass``, ``kept``.

    Raises
    ------
    ValueError
        Names a coordinate that is not finite, or two points in one place.

    Examples
    --------
    >>> import catamaran
    >>> points = catamaran.shapes.icosphere(3).v
    >>> stiffness, mass, kept = catamaran.cloud_laplacian(points)
    >>> [round(float(x)) for x in abs(catamaran.eigsh(stiffness, mass, 4).values)]  # of a sphere
    [0, 2, 2, 2]
    """
    stiffness, masses, kept = _catamaran.cloud_laplacian(
        points, neighbours, boundary, threads, callback(progress)
    )
    return Laplacian(to_scipy(stiffness), to_scipy(masses), kept)


@takes_mesh
def gradient(v: ArrayLike, f: ArrayLike) -> Any:
    """Assembles the gradient of functions that are linear on faces.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.

    Returns
    -------
    scipy.sparse.csr_array, 3 m x n
        Rows 3 i to 3 i + 2 are the components x, y, z in face i, per unit of length:
        ``(gradient(v, f) @ u).reshape(-1, 3)``.

    Raises
    ------
    ValueError
        Names a face without area.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.grid(1, 1)
    >>> (catamaran.gradient(mesh) @ mesh.v[:, 0]).reshape(-1, 3)  # of x
    array([[1., 0., 0.],
           [1., 0., 0.]])
    """
    return to_scipy(_catamaran.gradient(v, f, False))


@takes_mesh
def divergence(v: ArrayLike, f: ArrayLike) -> Any:
    """Assembles the divergence of vector fields that are constant on faces.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.

    Returns
    -------
    scipy.sparse.csr_array, n x 3 m
        Of fields as `gradient` has them, integrated over the surroundings of each vertex: times the
        gradient it is minus the cotangent stiffness of `laplacian`. ``Mesh.vertex_areas`` divides
        it.

    Raises
    ------
    ValueError
        Names a face without area.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.icosphere(2)
    >>> product = catamaran.divergence(mesh) @ catamaran.gradient(mesh)
    >>> bool(abs(product + catamaran.laplacian(mesh).stiffness).max() < 1e-12)
    True
    """
    return to_scipy(_catamaran.gradient(v, f, True))


def dirichlet_energies(
    functions: ArrayLike, stiffness: Any, mass: Any = None
) -> NDArray[np.float64]:
    """Computes the Dirichlet energy of each function: ``q W q / q M q`` (thesis, definition 7).

    Parameters
    ----------
    functions : array_like, n x c, or n numbers
        The functions q.
    stiffness : matrix of scipy.sparse, n x n
        W, as of `laplacian`.
    mass : matrix of scipy.sparse, or array_like of n numbers, optional
        M; the identity by default.

    Returns
    -------
    ndarray of c numbers
        In units of 1 / length^2: the eigenvalue for an eigenfunction, 0 for the function zero.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> mesh = catamaran.shapes.icosphere(2)
    >>> stiffness, mass, _ = catamaran.laplacian(mesh)
    >>> values, vectors = catamaran.eigsh(mesh, k=4)
    >>> bool(np.allclose(catamaran.dirichlet_energies(vectors, stiffness, mass), values))
    True
    """
    return _catamaran.dirichlet_energies(functions, csr("stiffness", stiffness), mass_of(mass))


class Eigenpairs(NamedTuple):
    """Eigenpairs of `eigsh`."""

    #: k values, ascending.
    values: NDArray[np.float64]
    #: n x k, orthonormal in the inner product of the mass.
    vectors: NDArray[np.float64]

    def plot(self, ax: Any = None) -> Any:
        """Draws the values by matplotlib, the first one above 0."""
        ax = axes(ax)
        ax.plot(np.arange(len(self.values)), self.values, ".-")
        ax.set(xlabel="number", ylabel="eigenvalue")
        return ax


def _refuse_options_of_meshes(
    *,
    kind: Kind = "cotangent",
    mass: Any = "barycentric",
    boundary: Union[Boundary, ArrayLike] = "neumann",
    weld: bool = False,
) -> None:
    """Refuses the options of `laplacian` where a matrix is given, which has no use for them."""
    hint = "; that of a matrix is the second argument"
    for name, value, default, more in (
        ("kind", kind, "cotangent", ""),
        ("mass", mass, "barycentric", hint),
        ("boundary", boundary, "neumann", ""),
        ("weld", weld, False, ""),
    ):
        # An array or a matrix is never a default, and is not compared with one.
        if np.ndim(value) > 0 or is_sparse(value) or value != default:
            raise ValueError(f"{name}: applies to a mesh, and a matrix is given{more}")


@with_mesh
def eigsh(
    v: Any,
    f: Any = None,
    k: int = 100,
    *,
    kind: Kind = "cotangent",
    mass: MassKind = "barycentric",
    boundary: Union[Boundary, ArrayLike] = "neumann",
    sigma: Optional[float] = None,
    tol: float = 1e-9,
    verify_count: bool = False,
    seed: int = 0,
    weld: bool = False,
    prolongation: Any = None,
    memory: Optional[int] = None,
    sink: Optional[Callable[[NDArray[np.float64], NDArray[np.float64]], Any]] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
    comm: Any = None,
) -> Eigenpairs:
    """Computes the first eigenpairs of the Laplacian of a mesh, or of a sparse pencil.

    ``eigsh(v, f, k)`` and ``eigsh(mesh, k)`` take a mesh. ``eigsh(A, M, k)`` takes a symmetric
    positive semi-definite matrix of scipy.sparse and a mass: a positive definite one, a vector, or
    None.

    Every component of a mesh without a vertex held at zero has an eigenvalue zero. Without `sigma`
    a warning says how many there are where the mesh has several components. Another one says how
    many vertices are in no face.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces; or the matrices.
    k : int
        Eigenpairs, at most the number of rows.
    kind, mass, boundary
        As in `laplacian`; for a mesh. Vectors are zero where boundary values are set to zero.
    sigma : float, optional
        The k eigenvalues nearest to this number, which may be an eigenvalue; the k smallest by
        default.
    tol : float
        Residual that every pair reaches, relative to the largest that its mass lets it have.
    verify_count : bool
        Whether eigenvalues are counted by a factorization, until none is missing.
    seed : int
        Of the vectors that the iteration starts with.
    weld : bool
        Whether vertices with equal positions are joined, as along the seams of a texture. Results
        have a row for each vertex of `v`.
    prolongation : matrix of scipy.sparse, n x c, optional
        Functions on the n vertices, or rows, of those on a coarse mesh, such as the weights of
        `decimate`. The pairs are those of the space of its columns, smoothed: they are approximate,
        with values that are never too small, and take a fraction of the time. Without `sigma` and
        `verify_count`; `tol` does not apply.
    memory : int, optional
        Bytes that the computation may take beside the matrices: with `sink`, the k smallest pairs
        are found slice by slice, and their count is verified.
    sink : callable, optional
        Takes the values (k) and the vectors (n x k) of each slice, in ascending order. The result
        then has all values, and `vectors` has no columns.
    threads, progress
        As in `ata`.
    comm : communicator of mpi4py, optional
        Every rank of it has some rows of a matrix and of its mass, in the order of the ranks, and
        gets its rows of the vectors; the basis and the factorization are distributed. Needs a
        package built with ``--features mpi`` for the MPI library of mpi4py. Without `progress`.

    Returns
    -------
    Eigenpairs
        ``values``, ``vectors``, in the order of `scipy.sparse.linalg.eigsh`.

    Examples
    --------
    >>> import catamaran
    >>> values, vectors = catamaran.eigsh(*catamaran.shapes.icosphere(4), 4)
    >>> [float(round(value, 2)) for value in abs(values)]  # of a sphere: 0, 2, 2, 2
    [0.0, 2.0, 2.0, 2.0]
    """
    search: Dict[str, Any] = {
        "k": k,
        "sigma": sigma,
        "tol": tol,
        "verify_count": verify_count,
        "seed": seed,
        "prolongation": None if prolongation is None else csr("prolongation", prolongation),
        "memory": memory,
        "sink": sink,
        "threads": threads,
    }
    if is_sparse(v) and f is not None and not is_sparse(f) and np.ndim(f) == 0:
        raise TypeError(f"mass: got {f!r}; the number of pairs is a keyword: eigsh(a, k={f!r})")
    if comm is not None or is_sparse(v):
        _refuse_options_of_meshes(kind=kind, mass=mass, boundary=boundary, weld=weld)
    if comm is not None:
        from ._ranks import gathered

        others = {"prolongation": prolongation, "memory": memory, "sink": sink}
        for name, given in {**others, "progress": progress}.items():
            if given is not None:
                raise ValueError(f"comm: not together with {name}")
        rows: List[Any] = []
        gathered(comm, lambda: rows.extend(own_rows(v, f)))
        pairs = _catamaran.eigsh_ranks(rows[0], rows[1], search, comm.py2f())
    elif is_sparse(v):
        pairs, free = _catamaran.eigsh_sparse(csr("a", v), mass_of(f), search, callback(progress))
        if free > 1 and sigma is None:
            zeros = f"{free} eigenvalues are zero"
            warn_caller(f"{zeros}: {free} components of the matrix have rows of sum 0")
    else:
        pairs, pieces = _catamaran.eigsh(
            v, f, search, kind, mass, boundary, weld, callback(progress)
        )
        dirichlet = isinstance(boundary, str) and boundary == "dirichlet"
        warn_of_pieces(pieces, dirichlet=dirichlet, shifted=sigma is not None, name="")
    return Eigenpairs(*pairs)


@takes_mesh
def count_below(
    v: Any,
    f: Any,
    value: float,
    *,
    kind: Kind = "cotangent",
    mass: MassKind = "barycentric",
    boundary: Union[Boundary, ArrayLike] = "neumann",
    weld: bool = False,
    threads: Optional[int] = None,
) -> int:
    """Counts the eigenvalues below a value, by one factorization (Sylvester's inertia).

    ``count_below(v, f, value)`` and ``count_below(mesh, value)`` take a mesh, and
    ``count_below(A, M, value)`` a matrix and a mass, as `eigsh` takes them.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces; or the matrices.
    value : float
        The value, in units of 1 / length^2; not an eigenvalue.
    kind, mass, boundary, weld, threads
        As in `laplacian`; for a mesh.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        For a value that is an eigenvalue up to rounding.

    Examples
    --------
    >>> import catamaran
    >>> catamaran.count_below(catamaran.shapes.icosphere(3), 4.0)  # of a sphere: 0, 2, 2, 2, 6
    4
    """
    if is_sparse(v):
        _refuse_options_of_meshes(kind=kind, mass=mass, boundary=boundary, weld=weld)
        return _catamaran.count_below_sparse(csr("a", v), mass_of(f), value)
    return _catamaran.count_below_mesh(v, f, kind, mass, boundary, weld, threads, value)


@with_mesh
def free_components(
    v: Any,
    f: Any = None,
    *,
    boundary: Union[Boundary, ArrayLike] = "neumann",
    weld: bool = False,
) -> int:
    """Counts the eigenvalues that are zero whatever the shape is: the dimension of the kernel.

    There is one for each component of a mesh without a vertex held at zero, and for each component
    of the graph of a matrix and its mass, ``free_components(A, M)``, whose rows sum to zero.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces; or the matrices, as `eigsh` takes them.
    boundary, weld
        As in `laplacian`; for a mesh.

    Returns
    -------
    int

    Examples
    --------
    >>> import catamaran
    >>> catamaran.free_components(catamaran.shapes.torus())
    1
    >>> catamaran.free_components(catamaran.shapes.disk(), boundary="dirichlet")
    0
    """
    if is_sparse(v):
        _refuse_options_of_meshes(boundary=boundary, weld=weld)
        return _catamaran.free_components_sparse(csr("a", v), mass_of(f))
    return _catamaran.free_components_mesh(v, f, boundary, weld)


def own_rows(a: Any, mass: Any) -> Tuple[Any, Any]:
    """Returns the rows of a matrix and of its mass on this rank as the extension takes them."""
    if not is_sparse(a):
        raise TypeError("v: with comm a matrix of scipy.sparse, of which each rank has some rows")
    if mass is None or is_sparse(mass):
        return csr("a", a), mass_of(mass)
    masses = np.asarray(mass, dtype=np.float64)
    if masses.shape != a.shape[:1]:
        raise ValueError(f"mass: shape {masses.shape}, where v has {a.shape[0]} rows on this rank")
    return csr("a", a), masses
