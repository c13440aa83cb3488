"""Meshes as pairs of arrays, and those of other packages."""

from __future__ import annotations

from functools import wraps
from typing import (
    Any,
    Callable,
    Concatenate,
    NamedTuple,
    Optional,
    ParamSpec,
    Protocol,
    Tuple,
    TypeVar,
    Union,
    cast,
    overload,
)

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._show import axes

__all__ = ["Mesh", "MeshLike", "mesh_arrays", "takes_mesh", "with_mesh"]


class Mesh(NamedTuple):
    """A mesh: a pair of arrays, which is given back as a mesh of another package on request.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.icosphere(2)
    >>> v, f = mesh
    >>> values, vectors = catamaran.eigsh(mesh, k=4)
    """

    #: Vertices, n x 3.
    v: NDArray[np.float64]
    #: Faces, m x 3.
    f: NDArray[Any]

    def to_trimesh(self, **options: Any) -> Any:
        """Return a `trimesh.Trimesh` with these vertices and faces; `options` go to it."""
        import trimesh

        return trimesh.Trimesh(self.v, self.f, **{"process": False, **options})

    def to_meshio(self, **options: Any) -> Any:
        """Return a `meshio.Mesh`, for files of other formats; `options` go to it."""
        import meshio

        return meshio.Mesh(self.v, [("triangle", self.f)], **options)

    def to_pyvista(self) -> Any:
        """Return a `pyvista.PolyData`."""
        import pyvista

        corners = np.full((len(self.f), 1), 3)
        return pyvista.PolyData(self.v, np.hstack([corners, self.f]).ravel())

    def plot(self, values: Optional[ArrayLike] = None, ax: Any = None, **options: Any) -> Any:
        """Draw the mesh by matplotlib.

        Parameters
        ----------
        values : array_like of n numbers, optional
            What faces are coloured by: the mean of the values at their vertices.
        ax : matplotlib axes, optional
            Axes with ``projection="3d"``; a new figure by default.
        options
            Go to ``plot_trisurf``.

        Returns
        -------
        The axes.
        """
        ax = axes(ax, projection="3d")
        x, y, z = self.v.T
        drawn = ax.plot_trisurf(x, y, z, triangles=self.f, **options)
        if values is not None:
            drawn.set_array(np.asarray(values)[self.f].mean(axis=1))
        ax.set_aspect("equal")
        return ax


class _Vertices(Protocol):
    """A mesh of trimesh, or of a package with the same attributes."""

    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...


class _Points(Protocol):
    """A mesh of meshio or of pyvista."""

    @property
    def points(self) -> Any: ...


#: A mesh of this package, of trimesh, meshio or pyvista.
MeshLike = Union[Mesh, _Vertices, _Points]


def mesh_arrays(mesh: Any) -> Optional[Tuple[Any, Any]]:
    """Return vertices and faces of a mesh of this package, trimesh, meshio or pyvista; None for
    any other object, such as an array.

    Raises
    ------
    ValueError
        Names cells that are no triangles.
    """
    if isinstance(mesh, Mesh):
        return mesh
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if not hasattr(mesh, "points"):
        return None
    points = np.asarray(mesh.points)
    if hasattr(mesh, "cells_dict"):
        cells = {kind: np.asarray(all_of) for kind, all_of in mesh.cells_dict.items()}
        # Those of no area stay behind.
        others = sorted(cells.keys() - {"triangle", "line", "vertex"})
        if others:
            raise ValueError(f"mesh: cells of {', '.join(others)}, expected triangles")
        return points, cells.get("triangle", np.empty((0, 3), dtype=np.int64))
    if hasattr(mesh, "faces"):
        faces = np.asarray(mesh.faces)
        if len(faces) % 4 != 0 or np.any(faces[::4] != 3):
            raise ValueError("mesh: faces that are not triangles; triangulate() makes them so")
        return points, faces.reshape(-1, 4)[:, 1:]
    return None


F = TypeVar("F", bound=Callable[..., Any])
P = ParamSpec("P")
R = TypeVar("R", covariant=True)


def with_mesh(function: F) -> F:
    """Make a function of (v, f, ...) take a mesh as (mesh, ...), too."""

    @wraps(function)
    def taking(v: Any, *arguments: Any, **named: Any) -> Any:
        mesh = mesh_arrays(v)
        if mesh is None:
            return function(v, *arguments, **named)
        return function(*mesh, *arguments, **named)

    return cast(F, taking)


class MeshFunction(Protocol[P, R]):
    """A function of `takes_mesh`."""

    @overload
    def __call__(self, v: ArrayLike, f: ArrayLike, *args: P.args, **kwargs: P.kwargs) -> R: ...
    @overload
    def __call__(self, v: MeshLike, *args: P.args, **kwargs: P.kwargs) -> R: ...


def takes_mesh(function: Callable[Concatenate[ArrayLike, ArrayLike, P], R]) -> MeshFunction[P, R]:
    """Do as `with_mesh`, and tell type checkers."""
    return cast(MeshFunction[P, R], with_mesh(function))
