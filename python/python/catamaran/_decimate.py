"""Uniform decimation and farthest points."""

from __future__ import annotations

from typing import Any, List, NamedTuple, Optional, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, to_nearest, to_scipy, warn_caller
from ._surface import Mesh, MeshLike, MeshOrArrays, blended, mesh_arrays, needed, takes_mesh
from ._words import Reduction

__all__ = ["Decimated", "Difference", "FarthestPoints", "Origin", "decimate", "farthest_points"]


class Origin(NamedTuple):
    """Where the new vertices are on the input."""

    #: A face of the input for each new vertex.
    face: NDArray[Any]
    #: Barycentric coordinates of the vertex there.
    barycentric: NDArray[np.float64]


class Difference(NamedTuple):
    """Distances between the vertices of a mesh and the surface of another one, of
    `Decimated.difference` (thesis, equation 5.8)."""

    #: The largest one, of either mesh, in units of length.
    hausdorff: float
    #: The mean of the squares of those of the one mesh, plus that of the other one.
    chamfer: float
    #: Both as the thesis prints them, between vertices alone.
    printed_hausdorff: float
    printed_chamfer: float
    #: An upper bound of the distance of any point of either surface from the other one: the
    #: Hausdorff distance, or at most 1 % more.
    hausdorff_bound: float


class Decimated(NamedTuple):
    """A mesh of `decimate`."""

    #: n x 3.
    v: NDArray[np.float64]
    #: m x 3.
    f: NDArray[Any]
    #: Where the vertices are on the input.
    origin: Origin
    #: ``weights @ g`` are functions on the input for functions g on the new mesh: a row for each
    #: vertex of the input, barycentric coordinates of the nearest point.
    weights: Any

    @to_nearest
    def carried(self, f: Union[ArrayLike, MeshLike], values: ArrayLike) -> NDArray[Any]:
        """Returns values at the new vertices of those at vertices of the input.

        Parameters
        ----------
        f : array_like
            Faces of the input; or the mesh.
        values : array_like, a row for each vertex of the input
            Colours, functions, or other numbers; texture coordinates if the mesh has no seams.

        Returns
        -------
        ndarray, a row for each vertex
            Not rounded, and between the values at the corners of a face.
        """
        mesh = mesh_arrays(f)
        faces = np.asarray(f if mesh is None else mesh[1])
        count = int(self.origin.face.max(initial=-1)) + 1
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) < count:
            raise ValueError(f"f: expected at least {count} faces, m x 3, got {faces.shape}")
        return blended(values, faces[self.origin.face], self.origin.barycentric, faces)

    @property
    def mesh(self) -> Mesh:
        """The vertices and faces."""
        return Mesh(self.v, self.f)

    def difference(self, mesh: MeshOrArrays, *, threads: Optional[int] = None) -> Difference:
        """Measures distances between a mesh, such as the input, and the result."""
        return Difference(*_catamaran.difference(needed("mesh", mesh), self.mesh, threads))


@takes_mesh
def decimate(
    v: ArrayLike,
    f: ArrayLike,
    n: Optional[int] = None,
    *,
    error: Optional[float] = None,
    method: Reduction = "uniform",
    resample: bool = True,
    lloyd: int = 0,
    relaxation: int = 12,
    uniform: bool = False,
    cut_narrow_handles: bool = False,
    first: Optional[int] = None,
    locked: ArrayLike = (),
    density: ArrayLike = (),
    curvature: float = 1.0,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Decimated:
    """Decimates a mesh uniformly to exactly `n` vertices, or to as few as `error` allows.

    The result is a manifold with the pieces, boundary loops and handles of the input, and nearly
    equal triangles.

    Parameters
    ----------
    v, f : array_like
        Vertices and faces of the input.
    n : int
        Vertices of the result.
    error : float
        Instead of `n`: the largest distance of a point of either surface from the other one, in
        units of the mesh. The result has as few vertices as a search finds, at most 2 % more than
        a number that is too small; `Difference.hausdorff_bound` is at most `error`.
    method : {"uniform", "thesis"}
        "thesis" is the algorithm as the thesis states it; its result is not always a manifold.
    resample : bool
        Whether edges longer than those of the result are split first.
    lloyd, relaxation : int
        Passes that move samples to the centroids of their cells, and that improve the result.
    uniform : bool
        Whether areas are made as equal as possible, at the cost of the shapes of triangles.
    cut_narrow_handles : bool
        Whether handles too narrow for the triangles of the result are cut, and closed.
    first : int, optional
        The vertex that sampling starts at.
    locked : array_like of int
        Vertices that stay, each once, or a mask of all vertices: they are the first of the
        result, in this order, at exactly the same positions. Edges between them stay, too,
        except for those longer than the edges of the result, of which a warning tells.
    density : array_like
        Vertices of the result per area, relative to elsewhere: a positive number for each vertex
        of the input, of which only ratios count; the same everywhere by default.
    curvature : float
        Up to how many times as many vertices per area where the surface bends, such as 16. With
        `density`, both factors count.
    threads, progress
        As in `ata`.

    Returns
    -------
    Decimated
        ``v``, ``f``, ``origin``, ``weights``.

    Examples
    --------
    >>> import catamaran
    >>> v, f, origin, weights = catamaran.decimate(*catamaran.shapes.icosphere(4), 100)
    >>> v.shape, f.shape, weights.shape
    ((100, 3), (196, 3), (2562, 100))
    """
    how = {
        "method": method,
        "resample": resample,
        "lloyd": lloyd,
        "relaxation": relaxation,
        "uniform": uniform,
        "cut_narrow_handles": cut_narrow_handles,
        "first": first,
        "locked": _numbers("locked", locked, v),
        "density": np.asarray(density, dtype=np.float64).ravel().tolist(),
        "curvature": curvature,
        "threads": threads,
    }
    v, f, face, inside, weights, lost = _catamaran.decimate(
        v, f, n, error, how, callback(progress)
    )
    if lost:
        warn_caller(
            f"{lost} edges between locked vertices are longer than those of the result, and not in "
            "it"
        )
    return Decimated(v, f, Origin(face, inside), to_scipy(weights))


def _numbers(name: str, vertices: ArrayLike, v: ArrayLike) -> List[int]:
    """Returns the numbers of vertices, which may come as a mask of all vertices `v`.

    `name` is that of the argument, in errors.
    """
    array = np.asarray(vertices)
    if array.dtype == bool:
        if array.shape != np.shape(v)[:1]:
            shape = np.shape(v)[:1]
            raise ValueError(f"{name}: expected a mask of shape {shape}, got {array.shape}")
        array = np.flatnonzero(array)
    return cast(List[int], array.ravel().tolist())


class FarthestPoints(NamedTuple):
    """Samples of `farthest_points` with their cells."""

    #: Vertices, each farthest from those before.
    samples: NDArray[Any]
    #: The number of the nearest sample, for each vertex of the mesh; -1 where none is reached.
    cells: NDArray[Any]
    #: The distance to it, along edges.
    distances: NDArray[np.float64]


@takes_mesh
def farthest_points(
    v: ArrayLike,
    f: ArrayLike,
    n: int,
    *,
    first: Optional[int] = None,
    return_cells: bool = False,
    progress: Progress = None,
) -> Any:
    """Chooses `n` vertices, each the farthest from those before, along edges.

    Parameters
    ----------
    v, f : array_like
        Vertices and faces.
    n : int
        Samples.
    first : int, optional
        The first one; the lowest vertex that a face has by default.
    return_cells : bool
        Whether the cells of all vertices are returned, too.
    progress
        As in `ata`.

    Returns
    -------
    ndarray of n vertices, or FarthestPoints

    Examples
    --------
    >>> import catamaran
    >>> catamaran.farthest_points(*catamaran.shapes.grid(4, 4), 4, first=0)
    array([ 0, 24,  4, 20])
    """
    found = _catamaran.farthest_points(v, f, n, first, callback(progress))
    return FarthestPoints(*found) if return_cells else found[0]
