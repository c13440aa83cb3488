"""Distances and shortest paths on meshes."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, some
from ._surface import takes_mesh
from ._words import DistanceMethod, Kind

__all__ = [
    "GeodesicPath",
    "GeodesicTrace",
    "ShortestPath",
    "distances",
    "geodesic_path",
    "shortest_path",
    "trace_geodesic",
]


@takes_mesh
def distances(
    v: ArrayLike,
    f: ArrayLike,
    sources: ArrayLike,
    *,
    weights: Optional[ArrayLike] = None,
    method: DistanceMethod = "heat",
    time: float = 1.0,
    kind: Kind = "tufted",
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Computes the distance of each vertex from the nearest source.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    sources : int, or array_like of vertices
        Where distances are 0. With `weights`, points of these faces.
    weights : array_like, a row of 3 numbers for each source
        Of exact distances: barycentric coordinates of the sources in their faces. None: the
        sources are vertices.
    method : {"heat", "exact", "edges"}
        Over the surface by the heat method, which is not exact, or exactly up to rounding; or
        along edges.
    time : float
        For the heat method: time of the flow in units of the squared mean length of edges. A longer
        time gives smoother distances.
    kind : {"tufted", "intrinsic", "cotangent"}
        For the heat method: the triangles that heat flows on, as in `laplacian`.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray of n numbers
        Infinite where no path leads.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.grid(4, 4)
    >>> catamaran.distances(mesh, [0], method="edges")[[1, 4]] * 4
    array([1., 4.])
    """
    return _catamaran.distances(
        v, f, some(sources), weights, method, time, kind, threads, callback(progress)
    )


class ShortestPath(NamedTuple):
    """A path of `shortest_path`."""

    #: Vertices along the path, both ends included; none without a path.
    vertices: NDArray[Any]
    #: Their positions.
    points: NDArray[np.float64]
    #: Its length; infinite without a path.
    length: float


@takes_mesh
def shortest_path(v: ArrayLike, f: ArrayLike, start: int, end: int) -> ShortestPath:
    """Finds the shortest path along edges from the vertex `start` to the vertex `end`.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    start, end : int
        Vertices.

    Returns
    -------
    ShortestPath

    Examples
    --------
    >>> import catamaran
    >>> found = catamaran.shortest_path(catamaran.shapes.grid(2, 2), 0, 2)
    >>> found.vertices, found.length
    (array([0, 1, 2]), 1.0)
    """
    return ShortestPath(*_catamaran.shortest_path(v, f, start, end))


class GeodesicPath(NamedTuple):
    """A path of `geodesic_path`."""

    #: Where it starts, crosses edges, passes vertices and ends; no rows without a path.
    points: NDArray[np.float64]
    #: The face of each point.
    faces: NDArray[Any]
    #: The barycentric coordinates of each point in its face.
    weights: NDArray[np.float64]
    #: Its length; infinite without a path.
    length: float


@takes_mesh
def geodesic_path(
    v: ArrayLike,
    f: ArrayLike,
    through: ArrayLike,
    *,
    weights: Optional[ArrayLike] = None,
    progress: Progress = None,
) -> GeodesicPath:
    """Finds the shortest path over faces that leads through points in their order.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    through : array_like of vertices
        At least two: the first and the last are the ends. With `weights`, points of these faces.
    weights : array_like, a row of 3 numbers for each point
        Barycentric coordinates of the points in their faces. None: the points are vertices.
    progress
        As in `ata`.

    Returns
    -------
    GeodesicPath

    Examples
    --------
    >>> import catamaran
    >>> path = catamaran.geodesic_path(catamaran.shapes.grid(1, 1), [1, 2])
    >>> len(path.points), round(path.length, 6)
    (3, 1.414214)
    """
    return GeodesicPath(*_catamaran.geodesic_path(v, f, through, weights, callback(progress)))


class GeodesicTrace(NamedTuple):
    """A geodesic of `trace_geodesic`."""

    #: Where it starts, crosses edges, passes vertices and ends.
    points: NDArray[np.float64]
    #: The face of each point.
    faces: NDArray[Any]
    #: The barycentric coordinates of each point in its face.
    weights: NDArray[np.float64]
    #: Its length: the length asked for, or less if it stops.
    length: float
    #: How it ends: "complete", or where it stops, at the "boundary", or "non-manifold": where more
    #: than one way leads on.
    end: str
    #: Its direction at the end, of length 1, in the plane of the last face.
    direction: NDArray[np.float64]


@takes_mesh
def trace_geodesic(
    v: ArrayLike,
    f: ArrayLike,
    start: int,
    direction: ArrayLike,
    length: float,
    *,
    weights: Optional[ArrayLike] = None,
    progress: Progress = None,
) -> GeodesicTrace:
    """Traces the geodesic that leaves a point in a direction, for a length.

    It is straight over faces and edges, and passes vertices with equal angles on both sides
    (Polthier and Schmies 1998). It stops at the boundary, and where more than one way leads on.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    start : int
        A vertex; with `weights`, a face.
    direction : 3 numbers
        Of any length. It is projected onto the face of the start; at a vertex it stands for the
        nearest direction over a face.
    length : float
        At least 0.
    weights : 3 numbers
        Barycentric coordinates of the start in its face. None: the start is a vertex.
    progress
        As in `ata`.

    Returns
    -------
    GeodesicTrace

    Examples
    --------
    >>> import catamaran
    >>> trace = catamaran.trace_geodesic(catamaran.shapes.grid(5, 5), 0, [3, 4, 0], 7)
    >>> round(trace.length, 6), trace.end
    (1.25, 'boundary')
    """
    path, end, heading = _catamaran.trace_geodesic(
        v, f, start, direction, length, weights, callback(progress)
    )
    return GeodesicTrace(*path, end, heading)
