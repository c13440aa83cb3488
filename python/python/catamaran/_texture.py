"""Slime moulds on surfaces and Newton's fractals."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, matrix_of, warn_caller
from ._show import axes
from ._surface import takes_mesh
from ._words import Gradient

__all__ = ["Fractal", "Slime", "newton", "slime"]


class Slime(NamedTuple):
    """Textures of `slime`."""

    #: species x size x size, from 0 to 1; row 0 is at v = 0.
    texture: NDArray[np.float32]
    #: faces x 3 x 2: texture coordinates of the corners of faces.
    uv: NDArray[np.float64]
    #: steps x species: the mean of the pheromone over the surface, from 0 to 1.
    coverage: NDArray[np.float64]

    def plot(self, ax: Any = None) -> Any:
        """Draws the texture by matplotlib, the largest pheromone of any species at each texel."""
        ax = axes(ax)
        ax.imshow(self.texture.max(axis=0), origin="lower", extent=(0, 1, 0, 1))
        ax.set(xlabel="u", ylabel="v")
        return ax


@takes_mesh
def slime(
    v: ArrayLike,
    f: ArrayLike,
    steps: int = 900,
    *,
    agents: int = 1_000_000,
    species: int = 1,
    size: int = 2048,
    seed: int = 0,
    uv: Optional[ArrayLike] = None,
    start: Optional[ArrayLike] = None,
    ground: Optional[ArrayLike] = None,
    time_step: Optional[float] = None,
    movement_speed: Optional[float] = None,
    turn_speed: Optional[float] = None,
    vision_distance: Optional[float] = None,
    vision_angle: Optional[float] = None,
    evaporation_rate: Optional[float] = None,
    diffusion_rate: Optional[float] = None,
    turn_noise: Optional[float] = None,
    project: Optional[int] = None,
    gaussian: bool = False,
    length_rescaling: bool = True,
    device: str = "cpu",
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Slime:
    """Lets slime moulds grow over a mesh, as a texture.

    Parameters
    ----------
    v, f : array_like
        Vertices and faces.
    steps : int
        Steps of all agents.
    agents, species : int
        How many: agents below 2^32, species from 1 to 15.
    size : int
        Texels of a side of the texture, a multiple of 32, at most 16384.
    seed : int
        Of all random numbers.
    uv : array_like, faces x 3 x 2, optional
        Texture coordinates; every triangle becomes a chart of its own by default.
    start : array_like, size x size, optional
        1 where agents may start, 0 elsewhere.
    ground : array_like, size x size, optional
        0 where agents move freely, 1 for obstacles, 2 for what attracts them.
    time_step, movement_speed, turn_speed, vision_distance, vision_angle : float, optional
        As ``docs/algorithms/slime.md`` explains them, with its defaults.
    evaporation_rate, diffusion_rate, turn_noise : float, optional
        The same.
    project : int, optional
        Move by so many projections to the tangent plane a step, instead of unfolding triangles.
    gaussian : bool
        Blur in the texture, without regard to its seams.
    length_rescaling : bool
        Whether lengths are measured on the surface, not in the texture.
    device : str
        Where to compute: ``"cpu"``, or an OpenCL device by its number or a part of its name;
        ``"opencl"`` is the first GPU, or the first device if there is no GPU.
    threads, progress
        As in `ata`.

    Returns
    -------
    Slime
        ``texture``, ``uv``, ``coverage``.

    Warns
    -----
    UserWarning
        Says how many triangles overlap others in the texture, where they share trails.

    Examples
    --------
    >>> import catamaran
    >>> found = catamaran.slime(*catamaran.shapes.icosphere(2), 5, agents=1000, size=160)
    >>> found.texture.shape, bool(found.texture.max() > 0)
    ((1, 160, 160), True)
    """
    mould = {
        "agents": agents,
        "species": species,
        "size": size,
        "seed": seed,
        "time_step": time_step,
        "movement_speed": movement_speed,
        "turn_speed": turn_speed,
        "vision_distance": vision_distance,
        "vision_angle": vision_angle,
        "evaporation_rate": evaporation_rate,
        "diffusion_rate": diffusion_rate,
        "turn_noise": turn_noise,
        "project": project,
        "gaussian": gaussian,
        "length_rescaling": length_rescaling,
        "device": device,
        "threads": threads,
    }
    if uv is not None:
        uv = np.asarray(matrix_of("uv", uv), dtype=np.float64)
    texture, corners, coverage, count = _catamaran.slime(
        v, f, steps, mould, uv, start, ground, callback(progress)
    )
    if count > 0:
        warn_caller(
            f"faces share texture: {count} of {len(corners)} triangles overlap others; without uv "
            "there are no overlaps"
        )
    return Slime(texture, corners, coverage)


class Fractal(NamedTuple):
    """What `newton` finds for each point."""

    #: The number ``a * n + b`` of the root (a, b), for a polynomial of n roots.
    roots: NDArray[np.uint16]
    #: How fast it is reached: the smaller, the faster.
    convergence: NDArray[np.float32]

    def plot(self, ax: Any = None) -> Any:
        """Draws the roots of a plane by matplotlib, the largest y at the top."""
        if self.roots.ndim != 2:
            raise ValueError("plot: only the points of a plane can be drawn")
        ax = axes(ax)
        ax.imshow(self.roots, origin="upper")
        return ax


def newton(
    points: Optional[ArrayLike] = None,
    *,
    power: Optional[int] = None,
    roots: Optional[Sequence[complex]] = None,
    size: Union[int, Tuple[int, int], None] = None,
    center: Tuple[float, float] = (0.0, 0.0),
    extent: float = 3.0,
    volume: bool = False,
    iterations: int = 32,
    theta: float = 3.5,
    gradient: Gradient = "thesis",
    scale: float = 1.0,
    offset: Tuple[float, float, float] = (0.0, 0.0, 0.0),
    w: float = 0.0,
    device: str = "cpu",
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Fractal:
    """Computes Newton's fractal in four dimensions, at points or on a grid.

    Parameters
    ----------
    points : array_like, n x 3, optional
        Where, instead of on a grid: without `size`, `center`, `extent` and `volume`.
    power : int, optional
        The polynomial ``z^power - 1``; 3 by default.
    roots : sequence of complex, optional
        The roots of another polynomial.
    size : int or (width, height), optional
        Points of the grid along each side, of a cube the same number for all; 1024 in a plane and
        128 in a cube by default.
    center : (float, float)
        The middle of the plane; without `volume`.
    extent : float
        The width of the plane, or of the cube, whose middle is the origin.
    volume : bool
        Whether the grid is a cube of size^3 points.
    iterations : int
        Of Newton's method, at most 1000.
    theta : float
        The larger, the earlier a point counts as not converged.
    gradient : {"thesis", "shader"}
        How the speed of convergence is measured.
    scale, offset, w
        What points are multiplied by, after `offset` and the fourth coordinate are added.
    device : str
        Where to compute: ``"cpu"``, or an OpenCL device by its number or a part of its name;
        ``"opencl"`` is the first GPU, or the first device if there is no GPU.
    threads, progress
        As in `ata`.

    Returns
    -------
    Fractal
        ``roots`` and ``convergence``: n numbers; or height x width, the row of largest y first; or
        size x size x size, by z, y and x.

    Raises
    ------
    ValueError
        Names an argument that is out of range, or that has no meaning for these points.

    Warns
    -----
    UserWarning
        Says how many points reach no root; their root is the one nearest to where they are then.

    Examples
    --------
    >>> import catamaran
    >>> found = catamaran.newton(power=3, size=64)
    >>> found.roots.shape, int(found.roots.max())
    ((64, 64), 8)
    """
    if power is None and roots is None:
        power = 3
    given = {
        "size": size is not None,
        "center": tuple(center) != (0.0, 0.0),
        "extent": extent != 3.0,
        "volume": volume,
    }
    for name, is_given in given.items():
        if points is not None and is_given:
            raise ValueError(f"{name}: not together with points")
    if volume and given["center"]:
        raise ValueError("center: not together with volume")
    if size is None:
        size = 128 if volume else 1024
    width, height = (size, size) if isinstance(size, (int, np.integer)) else size
    if volume and width != height:
        raise ValueError(f"size: a volume needs the same number along each side, got {size}")
    kind = "list" if points is not None else "cube" if volume else "plane"
    shapes = {"cube": (width, width, width), "plane": (height, width)}
    at = {
        "kind": kind,
        "points": points,
        "size": (width, height),
        "center": list(center),
        "extent": extent,
    }
    fractal = {
        "power": power,
        "roots": None if roots is None else [(complex(z).real, complex(z).imag) for z in roots],
        "iterations": iterations,
        "theta": theta,
        "gradient": gradient,
        "scale": scale,
        "offset": list(offset),
        "w": w,
        "device": device,
        "threads": threads,
    }
    numbers, convergence, unreached = _catamaran.newton(at, fractal, callback(progress))
    if unreached > 0:
        warn_caller(
            f"{unreached} of {numbers.size} points reach no root in {iterations} iterations; raise "
            "iterations"
        )
    shape = shapes.get(kind, numbers.shape)
    return Fractal(numbers.reshape(shape), convergence.reshape(shape))
