"""Curves through samples on a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback
from ._show import axes
from ._surface import takes_mesh
from ._words import Mode

__all__ = ["Curve", "Curves", "curve"]


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve."""

    #: Samples (their numbers) in the order in which the curve visits them.
    order: NDArray[Any]
    #: Vertices of the mesh along the curve; numbers beyond them are points on edges.
    path: NDArray[Any]
    #: Positions along the curve.
    points: NDArray[np.float64]
    #: Whether it ends where it begins.
    closed: bool
    #: Its length.
    length: float

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the curve by matplotlib; `options` go to ``plot``."""
        ax = axes(ax, projection="3d")
        points = self.points if not self.closed else np.vstack([self.points, self.points[:1]])
        ax.plot(*points.T, **options)
        return ax


@dataclass(frozen=True, eq=False)
class Curves:
    """What `curve` found."""

    #: In words.
    outcome: str
    #: Whether every sample is on a curve.
    complete: bool
    #: The curves.
    curves: List[Curve]
    #: Samples that are on none.
    left_out: NDArray[Any]


@takes_mesh
def curve(
    v: ArrayLike,
    f: ArrayLike,
    samples: ArrayLike,
    *,
    open: bool = False,
    single: bool = False,
    steiner: bool = True,
    smooth: bool = False,
    mode: Mode = "robust",
    candidates: int = 5,
    start: int = 0,
    progress: Progress = None,
) -> Curves:
    """Reconstruct a curve on a mesh through vertices that are in no order.

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
    >>> import catamaran
    >>> v, f = catamaran.shapes.torus(40, 20)
    >>> found = catamaran.curve(v, f, [0, 400, 200, 600, 100, 700])
    >>> found.complete, len(found.curves[0].order)
    (True, 6)
    """
    how = {
        "mode": mode,
        "open": open,
        "single": single,
        "steiner": steiner,
        "candidates": candidates,
        "start": start,
        "smooth": smooth,
    }
    outcome, complete, found, left_out = _catamaran.curve(v, f, samples, how, callback(progress))
    return Curves(outcome, complete, [Curve(**one) for one in found], left_out)
