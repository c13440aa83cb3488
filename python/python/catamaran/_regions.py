"""Meshes that are cut open, and regions: sets of faces."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import matrix_of, some
from ._surface import Part, part, takes_mesh
from ._words import Side

__all__ = ["cut", "enclosed_faces", "region_boundary"]


@takes_mesh
def cut(v: ArrayLike, f: ArrayLike, along: ArrayLike) -> Part:
    """Cuts a mesh open along edges.

    A vertex whose faces the edges separate becomes several ones. Faces keep their order.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    along : array_like, count x 2
        The two vertices of each edge, such as `Curve.edges`.

    Returns
    -------
    Part
        ``mesh``, and for each of its ``vertices`` the one that it was.

    Raises
    ------
    ValueError
        Names two vertices that no edge joins.

    Examples
    --------
    >>> import catamaran
    >>> found = catamaran.cut(catamaran.shapes.grid(2, 1), [[2, 3]])
    >>> found.mesh.validate().components, found.vertices[6:]
    (2, array([2, 3]))
    """
    return part(_catamaran.cut(v, f, along))


@takes_mesh
def enclosed_faces(
    v: ArrayLike,
    f: ArrayLike,
    along: ArrayLike,
    *,
    side: Side = "small",
    seeds: Optional[ArrayLike] = None,
) -> NDArray[np.bool_]:
    """Finds the region that curves along edges enclose.

    The result is a mask: ``a | b``, ``a & b``, ``a & ~b``, ``a ^ b`` and ``~a`` are unions,
    intersections, differences and complements of regions, ``mesh.face_areas[a].sum()`` is the area
    of one, and ``mesh.submesh(np.flatnonzero(a))`` its part of the mesh.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    along : array_like, count x 2
        The two vertices of each edge, such as `Curve.edges`. Each curve leads from one side to the
        other; the boundary of the mesh bounds regions, too.
    side : {"small", "large"}
        The side of smaller or of larger area, on each part of the surface with curves.
    seeds : int, or array_like of vertices, optional
        The region is the pieces with these vertices instead, which are on no curve.

    Returns
    -------
    ndarray of m truth values

    Raises
    ------
    ValueError
        Names two vertices that no edge joins, a seed on a curve, or an edge with the same region on
        both sides: open curves and those around a handle enclose nothing.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.grid(3, 1)
    >>> catamaran.enclosed_faces(mesh, [[2, 3]])
    array([ True,  True, False, False, False, False])
    """
    return _catamaran.enclosed_faces(v, f, along, side, some(seeds))


@takes_mesh
def region_boundary(v: ArrayLike, f: ArrayLike, region: ArrayLike) -> NDArray[Any]:
    """Finds the edges between a region and the rest of a mesh.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    region : array_like of m truth values
        Whether each face is in the region, as of `enclosed_faces`.

    Returns
    -------
    ndarray, count x 2
        The two vertices of each edge, the lower number first; ascending.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.grid(3, 1)
    >>> catamaran.region_boundary(mesh, catamaran.enclosed_faces(mesh, [[2, 3]]))
    array([[2, 3]])
    """
    mask = matrix_of("region", region)
    if mask.dtype != np.bool_:
        raise TypeError(f"region: {mask.dtype}, where each face has a truth value")
    return _catamaran.region_boundary(v, f, mask.view(np.uint8))
