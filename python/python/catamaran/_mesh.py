"""Meshes: files, Laplacians and their spectra."""

from __future__ import annotations

import os
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import (
    Progress,
    callback,
    csr,
    is_sparse,
    mass_of,
    to_scipy,
    warn_caller,
    warn_of_pieces,
)
from ._show import axes
from ._surface import Mesh, MeshLike, mesh_arrays, takes_mesh, with_mesh
from ._words import Boundary, Kind, MassKind

__all__ = ["Eigenpairs", "Laplacian", "eigsh", "laplacian", "read_mesh", "write_mesh"]

Path = Union[str, "os.PathLike[str]"]


def read_mesh(path: Path, *, attributes: bool = False) -> Any:
    """Read a mesh, in a format of docs/guide/mesh-files.md, also with .gz or .xz after it.

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
    """Write a mesh in the format that the name says, as `read_mesh` reads it.

    Parameters
    ----------
    path : path
        The file; it appears whole or not at all.
    v, f : array_like, n x 3 and m x 3
        Vertices and faces; or a mesh instead of both.
    colors : array_like, n x 3 or n x 4, optional
        Colours of the vertices, from 0 to 1.
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
        uv = np.asarray(uv, dtype=np.float64)
    warn(path, _catamaran.write_mesh(path, mesh[0], mesh[1], colors, uv, overwrite, text))


def warn(path: Path, notes: Sequence[str]) -> None:
    """Turn notes about a file into warnings at the line that called this package."""
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
    """Assemble the Laplacian of a mesh as matrices of scipy.sparse.

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


class Eigenpairs(NamedTuple):
    """Eigenpairs of `eigsh`."""

    #: k values, ascending.
    values: NDArray[np.float64]
    #: n x k, orthonormal in the inner product of the mass.
    vectors: NDArray[np.float64]

    def plot(self, ax: Any = None) -> Any:
        """Draw the values by matplotlib, the first one above 0."""
        ax = axes(ax)
        ax.plot(np.arange(len(self.values)), self.values, ".-")
        ax.set(xlabel="number", ylabel="eigenvalue")
        return ax


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
    threads: Optional[int] = None,
    progress: Progress = None,
    comm: Any = None,
) -> Eigenpairs:
    """Compute the first eigenpairs of the Laplacian of a mesh, or of a sparse pencil.

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
        "threads": threads,
    }
    if comm is not None:
        from ._ranks import gathered

        if progress is not None:
            raise ValueError("comm: not together with progress")
        rows: List[Any] = []
        gathered(comm, lambda: rows.extend(own_rows(v, f)))
        pairs = _catamaran.eigsh_ranks(rows[0], rows[1], search, comm.py2f())
    elif is_sparse(v):
        pairs, free = _catamaran.eigsh_sparse(csr(v), mass_of(f), search, callback(progress))
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


def own_rows(a: Any, mass: Any) -> Tuple[Any, Any]:
    """Return the rows of a matrix and of its mass on this rank as the extension takes them."""
    if not is_sparse(a):
        raise TypeError("v: with comm a matrix of scipy.sparse, of which each rank has some rows")
    if mass is None or is_sparse(mass):
        return csr(a), mass_of(mass)
    masses = np.asarray(mass, dtype=np.float64)
    if masses.shape != a.shape[:1]:
        raise ValueError(f"mass: shape {masses.shape}, where v has {a.shape[0]} rows on this rank")
    return csr(a), masses
