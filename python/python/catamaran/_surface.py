"""Meshes as pairs of arrays, and those of other packages."""

from __future__ import annotations

import os
from functools import wraps
from typing import (
    Any,
    Callable,
    Concatenate,
    List,
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

from . import _catamaran
from ._measure import Comparison, OneSided, Quality, Validation
from ._options import matrix_of, to_nearest
from ._show import axes

__all__ = [
    "Mesh",
    "MeshLike",
    "MeshOrArrays",
    "Part",
    "Refined",
    "mesh_arrays",
    "takes_mesh",
    "with_mesh",
]


class _Arrays(NamedTuple):
    """What a `Mesh` is a tuple of."""

    #: Vertices, n x 3.
    v: NDArray[np.float64]
    #: Faces, m x 3.
    f: NDArray[Any]


class Mesh(_Arrays):
    """A mesh: a pair of arrays, which is given back as a mesh of another package on request.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces; or a mesh of trimesh, meshio or pyvista instead of both.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.icosphere(2)
    >>> v, f = mesh
    >>> values, vectors = catamaran.eigsh(mesh, k=4)
    >>> mesh.validate().genus, len(mesh.edges)
    (0, 480)
    """

    __slots__ = ()

    def __new__(cls, v: Union[ArrayLike, MeshLike], f: Optional[ArrayLike] = None) -> Mesh:
        found = needed("v", v) if f is None else (v, f)
        return super().__new__(cls, *map(array_of, ("v", "f"), found))

    def to_trimesh(self, **options: Any) -> Any:
        """Returns a `trimesh.Trimesh` with these vertices and faces; `options` go to it."""
        import trimesh

        return trimesh.Trimesh(self.v, self.f, **{"process": False, **options})

    def to_meshio(self, **options: Any) -> Any:
        """Returns a `meshio.Mesh`, for files of other formats; `options` go to it."""
        import meshio

        return meshio.Mesh(self.v, [("triangle", self.f)], **options)

    def to_pyvista(self) -> Any:
        """Returns a `pyvista.PolyData`."""
        import pyvista

        corners = np.full((len(self.f), 1), 3)
        return pyvista.PolyData(self.v, np.hstack([corners, self.f]).ravel())

    def _measure(self, what: str, threads: Optional[int] = None) -> Any:
        return _catamaran.measure(self.v, self.f, what, threads)

    @property
    def area(self) -> float:
        """The sum of the areas of the faces."""
        area: float = self._measure("area")
        return area

    @property
    def volume(self) -> Optional[float]:
        """The volume inside, below 0 if faces are clockwise as seen from outside; None unless the
        mesh has faces, is closed (every edge has two faces) and oriented."""
        volume: Optional[float] = self._measure("volume")
        return volume

    @property
    def face_areas(self) -> NDArray[np.float64]:
        """The area of each face."""
        areas: NDArray[np.float64] = self._measure("face_areas")
        return areas

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """A third of the areas of the faces at each vertex."""
        areas: NDArray[np.float64] = self._measure("vertex_areas")
        return areas

    @property
    def face_normals(self) -> NDArray[np.float64]:
        """The unit normal of each face, m x 3; zero for faces without area."""
        normals: NDArray[np.float64] = self._measure("face_normals")
        return normals

    @property
    def vertex_normals(self) -> NDArray[np.float64]:
        """The unit normal of each vertex, n x 3: the mean of those of its faces by area."""
        normals: NDArray[np.float64] = self._measure("vertex_normals")
        return normals

    @property
    def qualities(self) -> NDArray[np.float64]:
        """The quality of each face, from 0 (no area) to 1 (equilateral): 2 sqrt(3) area / (half
        the perimeter times the longest edge)."""
        qualities: NDArray[np.float64] = self._measure("qualities")
        return qualities

    @property
    def edges(self) -> NDArray[Any]:
        """The vertices of each edge, count x 2, the lower number first; ascending."""
        edges: NDArray[Any] = self._measure("edges")
        return edges

    @property
    def components(self) -> NDArray[Any]:
        """The number of the component of each face; components are in the order of their lowest
        vertices, and faces with a common vertex are in one."""
        components: NDArray[Any] = self._measure("components")
        return components

    @property
    def boundary_loops(self) -> List[NDArray[Any]]:
        """The vertices of each loop of the boundary, in order; a ValueError if there is a boundary
        and an edge of more than two faces."""
        loops: List[NDArray[Any]] = self._measure("boundary_loops")
        return loops

    def intersecting_faces(self, *, threads: Optional[int] = None) -> NDArray[Any]:
        """Returns the faces that meet another one away from common corners and edges, ascending."""
        faces: NDArray[Any] = self._measure("intersecting_faces", threads)
        return faces

    def validate(self) -> Validation:
        """Counts vertices, edges, faces and components, and lists problems of the mesh.

        Examples
        --------
        >>> import numpy as np
        >>> import catamaran
        >>> print(catamaran.Mesh(np.eye(3), np.array([[0, 1, 2], [0, 2, 1]])).validate().problems)
        [('repeated faces', 'face 1 as face 0')]
        """
        return Validation(**_catamaran.validate(self.v, self.f))

    def quality(self) -> Quality:
        """Measures how uniform the mesh is."""
        numbers, edges = _catamaran.quality(self.v, self.f)
        return Quality._make([*numbers, edges])

    def compare(self, other: MeshOrArrays, *, threads: Optional[int] = None) -> Comparison:
        """Measures how far the surface is from that of another mesh, and the other way round.

        Distances are those of the vertices, and of 100,000 points spread over each surface.
        """
        out, back = _catamaran.compare(self, needed("other", other), threads)
        return Comparison(OneSided(*out), OneSided(*back))

    def submesh(self, faces: ArrayLike) -> Part:
        """Returns the part of these faces, given by their numbers."""
        return part(_catamaran.submesh(self.v, self.f, faces))

    def component(self, number: int) -> Part:
        """Returns a component, as `components` numbers them from 0."""
        return part(_catamaran.component(self.v, self.f, number))

    def plot(self, values: Optional[ArrayLike] = None, ax: Any = None, **options: Any) -> Any:
        """Draws the mesh by matplotlib.

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


class Part(NamedTuple):
    """A part of a mesh, or a mesh that is cut open."""

    #: The part.
    mesh: Mesh
    #: For each of its vertices the number in the whole mesh.
    vertices: NDArray[Any]
    #: For each of its faces the number in the whole mesh.
    faces: NDArray[Any]


def part(found: Any) -> Part:
    """Returns a part of the extension."""
    mesh, vertices, faces = found
    return Part(Mesh(*mesh), vertices, faces)


class Refined(NamedTuple):
    """A finer mesh of the same surface; its first vertices are those of the coarse mesh."""

    #: The finer mesh.
    mesh: Mesh
    #: For each of its faces the face of the coarse mesh that contains it.
    faces: NDArray[Any]
    #: For each of its vertices three vertices of one coarse face.
    vertices: NDArray[Any]
    #: The weights of these vertices, with sum 1.
    weights: NDArray[np.float64]

    @to_nearest
    def carried(self, values: ArrayLike) -> NDArray[Any]:
        """Returns values at the vertices of the finer mesh, linear on coarse faces.

        Parameters
        ----------
        values : array_like, a row for each vertex of the coarse mesh
            Colours, functions, or other numbers.
        """
        return blended(values, self.vertices, self.weights, self.vertices)


def blended(values: Any, corners: Any, weights: Any, used: Any) -> NDArray[Any]:
    """Returns values at points, given by three vertices and their weights each.

    `values` have a row for each vertex, `used` are all vertices that need one. Rounding leaves no
    result outside of the values at the three.
    """
    given = matrix_of("values", values)
    count = int(used.max(initial=-1)) + 1
    if given.ndim == 0 or len(given) < count:
        raise ValueError(
            f"values: expected a row for each vertex, at least {count}, got {given.shape}"
        )
    three = given[corners]
    found: NDArray[Any] = np.einsum("ij,ij...->i...", weights, three)
    if found.dtype.kind != "c":
        np.clip(found, three.min(axis=1), three.max(axis=1), out=found)
    return found


def refined(found: Any) -> Refined:
    """Returns a finer mesh of the extension."""
    mesh, faces, vertices, weights = found
    return Refined(Mesh(*mesh), faces, vertices, weights)


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
#: A mesh, or its vertices and faces.
MeshOrArrays = Union[MeshLike, Tuple[ArrayLike, ArrayLike]]


def mesh_arrays(mesh: Any) -> Optional[Tuple[Any, Any]]:
    """Returns vertices and faces of a mesh of this package, trimesh, meshio or pyvista; None for
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
        # pyvista numbers kinds as VTK does, meshio names them.
        names = {1: "vertex", 3: "line", 5: "triangle"}
        cells = {
            names.get(kind, str(kind)): np.asarray(all_of)
            for kind, all_of in mesh.cells_dict.items()
        }
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


def array_of(name: str, a: Any) -> Any:
    """Returns an array as it is, a list as an array; a mask is refused."""
    return a if type(a) is np.ndarray else matrix_of(name, a)


def needed(name: str, mesh: Any) -> Tuple[Any, Any]:
    """Returns vertices and faces of a mesh, or of a pair of them."""
    found = mesh_arrays(mesh) or mesh
    if not isinstance(found, (tuple, list)) or len(found) != 2:
        kind = type(mesh).__name__
        raise TypeError(f"{name}: expected a mesh, or vertices and faces, got {kind}")
    return found[0], found[1]


def refuse_others(v: Any) -> None:
    """Refuses what people take for a mesh: the name of a file, and a scene of trimesh.

    Raises
    ------
    TypeError
        Says what makes a mesh of it.
    """
    if isinstance(v, (str, os.PathLike)):
        raise TypeError(f"v: expected a mesh, got a name: read_mesh({os.fspath(v)!r}) reads one")
    if hasattr(v, "geometry") and hasattr(v, "to_mesh"):
        raise TypeError(f"v: expected a mesh, got a {type(v).__name__}: to_mesh() makes one of it")


F = TypeVar("F", bound=Callable[..., Any])
P = ParamSpec("P")
R = TypeVar("R", covariant=True)
V = TypeVar("V", contravariant=True)


def with_mesh(function: F) -> F:
    """Makes a function of (v, f, ...) take a mesh as (mesh, ...), too."""

    @wraps(function)
    def taking(v: Any, *arguments: Any, **named: Any) -> Any:
        mesh = mesh_arrays(v)
        if mesh is None:
            refuse_others(v)
            return function(v, *arguments, **named)
        return function(*mesh, *arguments, **named)

    return cast(F, taking)


class MeshFunction(Protocol[V, P, R]):
    """A function of `takes_mesh`."""

    @overload
    def __call__(self, v: V, f: V, *args: P.args, **kwargs: P.kwargs) -> R: ...
    @overload
    def __call__(self, v: MeshLike, *args: P.args, **kwargs: P.kwargs) -> R: ...


def takes_mesh(function: Callable[Concatenate[V, V, P], R]) -> MeshFunction[V, P, R]:
    """Does as `with_mesh`, and tells type checkers."""
    return cast(MeshFunction[V, P, R], with_mesh(function))
