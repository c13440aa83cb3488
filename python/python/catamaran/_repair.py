"""Repair of meshes."""

from __future__ import annotations

from typing import Any, List, NamedTuple, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback
from ._surface import Mesh, array_of, takes_mesh
from ._words import Weld

__all__ = ["Repaired", "repair"]


class Repaired(NamedTuple):
    """A mesh of `repair`."""

    #: The mesh.
    mesh: Mesh
    #: For each vertex of the input the vertex of the mesh; -1 where it is left out.
    vertices: NDArray[Any]
    #: A line for each step, about what it did.
    report: List[str]


@takes_mesh
def repair(
    v: ArrayLike,
    f: ArrayLike,
    *,
    everything: bool = False,
    weld: Union[Weld, float] = "never",
    drop_duplicates: bool = False,
    drop_degenerate: bool = False,
    compact: bool = False,
    cut: bool = False,
    keep_largest: Optional[int] = None,
    drop_specks: Optional[float] = None,
    fill_holes: Optional[int] = None,
    orient: bool = False,
    progress: Progress = None,
) -> Repaired:
    """Repairs a mesh by the requested steps, in the order of the parameters.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    everything : bool
        Whether all steps are taken that need no number, and seams are welded.
    weld : {"never", "exact", "seams"} or float
        The vertices that are joined: none, those in the same place, those along boundary edges
        where exactly two coincide, or those at most this far apart.
    drop_duplicates : bool
        Whether faces with the vertices of an earlier one are left out.
    drop_degenerate : bool
        Whether faces without area are removed; those that have a vertex twice, which other
        functions refuse, before all other steps.
    compact : bool
        Whether vertices without a face are left out.
    cut : bool
        Whether the mesh is cut along edges of more than two faces, and where it meets itself.
    keep_largest : int, optional
        Components to keep, those with the most faces; all by default.
    drop_specks : float, optional
        Components with less than this share of the area, from 0 to 1, are left out.
    fill_holes : int, optional
        Holes of at most this many edges are filled.
    orient : bool
        Whether faces are flipped to agree with their neighbours, and in closed components so that
        they are counter-clockwise as seen from outside.
    progress
        As in `ata`.

    Returns
    -------
    Repaired
        ``mesh``, ``vertices``, ``report``.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> v, f = catamaran.shapes.icosphere(1)
    >>> soup = v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    >>> catamaran.repair(*soup, everything=True).mesh.v.shape
    (42, 3)
    """
    steps = {
        "everything": everything,
        "weld": weld,
        "drop_duplicates": drop_duplicates,
        "drop_degenerate": drop_degenerate,
        "compact": compact,
        "cut": cut,
        "keep_largest": keep_largest,
        "drop_specks": drop_specks,
        "fill_holes": fill_holes,
        "orient": orient,
    }
    collapsed = 0
    if everything or drop_degenerate:
        f, collapsed = without_collapsed(f)
    mesh, vertices, report = _catamaran.repair(v, f, steps, callback(progress))
    if collapsed > 0:
        report.insert(0, f"left out    facets with two equal corners: {collapsed}")
    return Repaired(Mesh(*mesh), vertices, report)


def without_collapsed(f: Any) -> Tuple[Any, int]:
    """Returns faces without those that have a vertex twice, and the number of these."""
    faces = array_of("f", f)
    if faces.ndim != 2 or faces.shape[1] != 3:
        # The error of the extension says so.
        return f, 0
    kept = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return (f, 0) if kept.all() else (faces[kept], int((~kept).sum()))
