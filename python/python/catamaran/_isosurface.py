"""Surfaces of functions and labels on lattices."""

from __future__ import annotations

from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike

from . import _catamaran
from ._options import Progress, callback, matrix_of
from ._surface import Mesh

__all__ = ["isosurface", "label_surface"]


def isosurface(
    values: ArrayLike,
    level: float = 0.0,
    *,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    step: Sequence[float] = (1.0, 1.0, 1.0),
    open: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Mesh:
    """Finds the surface of the region where a function on a lattice exceeds a level.

    By marching tetrahedra: the surface is a manifold for any values, with faces that are
    counter-clockwise as seen from outside.

    Parameters
    ----------
    values : array_like, nx x ny x nz
        The function at the points ``origin + step * (i, j, k)``, in single precision; linear
        between them, and not NaN.
    level : float
        The level.
    origin, step : three numbers
        The first point, and the distances of points along x, y and z, which are positive.
    open : bool
        Whether the surface ends at the outermost points and has a boundary there; otherwise it is
        closed half a step outside of them.
    threads, progress
        As in `ata`.

    Returns
    -------
    Mesh

    Raises
    ------
    ValueError
        For a value or a level that is NaN, or a step that is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> x, y, z = np.ogrid[-1.5:1.5:31j, -1.5:1.5:31j, -1.5:1.5:31j]
    >>> ball = catamaran.isosurface(1 - x**2 - y**2 - z**2, step=(0.1, 0.1, 0.1))
    >>> ball.validate().genus, round(ball.volume)  # 4 / 3 pi
    (0, 4)
    """
    numbers = matrix_of("values", values)
    if numbers.dtype == np.float64:
        # One copy, in the order and the precision of the extension.
        numbers = numbers.astype(np.float32, order="F")
    flat, lattice = of_lattice("values", numbers, origin, step, open, threads)
    return Mesh(*_catamaran.isosurface(flat, level, lattice, callback(progress)))


def label_surface(
    labels: ArrayLike,
    label: Any,
    *,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    step: Sequence[float] = (1.0, 1.0, 1.0),
    open: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Mesh:
    """Finds the surface of the region of one label on a lattice, as of a segmented image.

    Parameters
    ----------
    labels : array_like, nx x ny x nz
        The label of each point.
    label : scalar
        The label of the region. Vertices are halfway between points with it and points without.
    origin, step, open, threads, progress
        As in `isosurface`.

    Returns
    -------
    Mesh

    Examples
    --------
    >>> import catamaran
    >>> cube = catamaran.label_surface([[[4]], [[7]]], 7, origin=(0.5, 0.5, 0.5))
    >>> cube.v.min(axis=0), cube.v.max(axis=0)
    (array([1., 0., 0.]), array([2., 1., 1.]))
    """
    mask = np.asarray(matrix_of("labels", labels) == label)
    flat, lattice = of_lattice("labels", mask.view(np.uint8), origin, step, open, threads)
    return Mesh(*_catamaran.label_surface(flat, lattice, callback(progress)))


def of_lattice(
    name: str,
    values: Any,
    origin: Sequence[float],
    step: Sequence[float],
    open: bool,
    threads: Optional[int],
) -> Tuple[Any, Dict[str, Any]]:
    """Returns values, x fastest, and their lattice as the extension takes them."""
    if values.ndim != 3:
        raise ValueError(f"{name}: expected an array of 3 dimensions, got {values.ndim}")
    lattice = {
        "counts": values.shape,
        "origin": origin,
        "step": step,
        "open": open,
        "threads": threads,
    }
    return values.ravel(order="F"), lattice
