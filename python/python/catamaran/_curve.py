"""Curves through samples on a mesh, several of them drawn into it, and points as vertices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback
from ._show import axes
from ._surface import Refined, refined, takes_mesh
from ._words import Mode

__all__ = ["Curve", "Curves", "Drawn", "Placed", "curve", "draw", "place"]


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve."""

    #: Samples (their numbers) in the order in which the curve visits them.
    order: NDArray[Any]
    #: Vertices of the mesh along the curve; numbers beyond them are points on edges.
    path: NDArray[Any]
    #: Positions along the curve.
    points: NDArray[np.float64]
    #: For each point, a face of the mesh that was given.
    faces: NDArray[Any]
    #: The barycentric coordinates of each point in its face.
    barycentric: NDArray[np.float64]
    #: Whether it ends where it begins.
    closed: bool
    #: Its length.
    length: float

    @property
    def edges(self) -> NDArray[Any]:
        """The two vertices of each edge of the path, the lower number first."""
        ends = np.column_stack([self.path, np.roll(self.path, -1)])
        ends = ends if self.closed else ends[:-1]
        edges: NDArray[Any] = np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1)
        return edges

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draws the curve by matplotlib; `options` go to ``plot``."""
        ax = axes(ax, projection="3d")
        points = self.points if not self.closed else np.vstack([self.points, self.points[:1]])
        ax.plot(*points.T, **options)
        return ax


@dataclass(frozen=True, eq=False)
class Curves:
    """What `curve` found."""

    #: In words.
    outcome: str
    #: Whether every other sample is on a curve.
    complete: bool
    #: The curves.
    curves: List[Curve]
    #: Samples that are on none, because their components of the mesh have fewer than three.
    left_out: NDArray[Any]
    #: Samples that were dropped as outliers.
    outliers: NDArray[Any]


@takes_mesh
def curve(
    v: ArrayLike,
    f: ArrayLike,
    samples: ArrayLike,
    *,
    open: bool = False,
    single: bool = False,
    steiner: bool = True,
    drop_outliers: bool = False,
    smooth: bool = False,
    mode: Mode = "robust",
    candidates: int = 5,
    start: int = 0,
    progress: Progress = None,
) -> Curves:
    """Reconstructs a curve on a mesh through vertices that are in no order.

    Parameters
    ----------
    v, f : array_like
        Vertices and faces.
    samples : array_like of vertices
        Samples of the curve, in any order.
    open : bool
        Whether the curve has two ends; closed by default.
    single : bool
        One curve, also where there are gaps as between several.
    steiner : bool
        Whether points on edges may be taken where there is no other way.
    drop_outliers : bool
        Whether one or two successive samples are dropped, to which the curve makes a detour of more
        than three times the median distance between successive samples (at the ends of an open
        curve, six times). At least half of the samples stay. Not with "faithful".
    smooth : bool
        Straight over the faces between samples, not along edges.
    mode : {"robust", "faithful"}
        "faithful" is algorithm 6.1 of the thesis, which can lock itself in.
    candidates, start : int
        For "faithful": among how many samples the next one is chosen, and which is the first one.
    progress
        As in `ata`.

    Returns
    -------
    Curves

    Examples
    --------
    >>> import catamaran, numpy as np
    >>> v, f = catamaran.shapes.torus(40, 20)
    >>> found = catamaran.curve(v, f, [0, 400, 200, 600, 100, 700])
    >>> found.complete, len(found.curves[0].order)
    (True, 6)
    >>> one = found.curves[0]
    >>> corners = v[f[one.faces]]  # the points are on faces
    >>> bool(np.allclose((one.barycentric[:, :, None] * corners).sum(axis=1), one.points))
    True
    """
    how = options(mode, open, single, steiner, drop_outliers, candidates, start)
    return curves(_catamaran.curve(v, f, samples, how, smooth, callback(progress)))


def options(
    mode: str,
    open: bool,
    single: bool,
    steiner: bool,
    drop_outliers: bool,
    candidates: int,
    start: int,
) -> Dict[str, Any]:
    """Returns options of a curve as the extension takes them."""
    return {
        "mode": mode,
        "open": open,
        "single": single,
        "steiner": steiner,
        "drop_outliers": drop_outliers,
        "candidates": candidates,
        "start": start,
    }


def curves(found: Any) -> Curves:
    """Returns curves of the extension."""
    outcome, complete, all_of, left_out, outliers = found
    return Curves(outcome, complete, [Curve(**one) for one in all_of], left_out, outliers)


class Drawn(NamedTuple):
    """A mesh of `draw`."""

    #: The mesh with the curves along its edges, and where it is on the input.
    refined: Refined
    #: What was found of each layer; paths are vertices of the finer mesh.
    layers: List[Curves]


@takes_mesh
def draw(
    v: ArrayLike,
    f: ArrayLike,
    layers: Sequence[Tuple[ArrayLike, Mapping[str, Any]]],
    *,
    open: bool = False,
    single: bool = False,
    steiner: bool = True,
    drop_outliers: bool = False,
    smooth: bool = False,
    mode: Mode = "robust",
    candidates: int = 5,
    start: int = 0,
    progress: Progress = None,
) -> Drawn:
    """Draws curves into a mesh, so that they run along its edges.

    Curves of one layer do not meet; those of several layers may cross. Faces are cut along the
    curves, and no vertex moves.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    layers : sequence of (samples, options)
        Samples as `curve` takes them, each with a dictionary of the options `open`, `single`,
        `steiner`, `drop_outliers`, `mode`, `candidates` and `start` that differ in this layer.
    open, single, steiner, drop_outliers, mode, candidates, start
        As in `curve`, for all layers.
    smooth : bool
        Whether curves are straight over the faces between samples, in all layers.
    progress
        As in `ata`.

    Returns
    -------
    Drawn
        ``refined``, ``layers``.

    Raises
    ------
    ValueError
        Names a sample that is no vertex, or a face on which curves are too near to each other.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.grid(8, 8)
    >>> found = catamaran.draw(mesh, [([10, 64, 16, 70], {})], smooth=True)
    >>> edges = found.layers[0].curves[0].edges
    >>> inside = catamaran.enclosed_faces(found.refined.mesh, edges, seeds=[40])
    >>> round(float(found.refined.mesh.face_areas[inside].sum()), 9)  # 6 x 6 of 8 x 8 squares
    0.5625
    """
    common = options(mode, open, single, steiner, drop_outliers, candidates, start)
    own = []
    for samples, more in layers:
        unknown = sorted(set(more) - set(common))
        if unknown:
            raise TypeError(f"layers: unknown options {', '.join(unknown)}")
        own.append((samples, {**common, **more}))
    mesh, found = _catamaran.draw(v, f, own, smooth, callback(progress))
    return Drawn(refined(mesh), [curves(one) for one in found])


class Placed(NamedTuple):
    """Points of `place`."""

    #: The mesh in which they are vertices; the input itself where none is new.
    refined: Refined
    #: The vertex of each point.
    vertices: NDArray[Any]


@takes_mesh
def place(
    v: ArrayLike,
    f: ArrayLike,
    faces: ArrayLike,
    barycentric: ArrayLike,
    *,
    insert: bool = True,
) -> Placed:
    """Finds vertices for points on faces, such as samples of a curve or the origin of `decimate`.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    faces : array_like of count faces
        The face of each point.
    barycentric : array_like, count x 3
        Its barycentric coordinates there: not negative, with sum 1.
    insert : bool
        Whether a point that is not at a vertex becomes one, which cuts its face, or the faces of
        its edge; otherwise the corner with the largest coordinate takes its place.

    Returns
    -------
    Placed
        ``refined``, ``vertices``.

    Raises
    ------
    ValueError
        Names a point whose face does not exist or whose coordinates are wrong.

    Examples
    --------
    >>> import catamaran
    >>> mesh = catamaran.shapes.grid(2, 2)
    >>> found = catamaran.place(mesh, [0, 3], [[0.2, 0.3, 0.5], [0, 1, 0]])
    >>> int(found.vertices[0]), len(found.refined.mesh.v)  # the first one is new
    (9, 10)
    """
    mesh, vertices = _catamaran.place(v, f, faces, barycentric, insert)
    return Placed(refined(mesh), vertices)
