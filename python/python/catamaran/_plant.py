"""Plants that lose water and wilt."""

from __future__ import annotations

import os
from typing import Any, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _catamaran
from ._mesh import warn
from ._options import Progress, callback
from ._show import axes
from ._surface import Mesh

__all__ = ["Plant", "Wilting", "grow_plant", "read_plant", "wilt"]


class Plant:
    """A plant: segments, each from its head (the tail of its parent) to its tail.

    Attributes
    ----------
    tails : ndarray, n x 3
        In metres.
    radii : ndarray of n numbers
        In metres.
    parents : ndarray of n numbers
        The segment before each; -1 at the root.
    leaves : ndarray of n booleans
        Whether segments are veins of leaves.
    base : ndarray of 3 numbers
        The head of the root.
    """

    def __init__(self, handle: Any) -> None:
        self._handle = handle
        self.tails: NDArray[np.float64]
        self.tails, self.radii, self.parents, self.leaves, self.base = handle.arrays()

    def __reduce__(self) -> Tuple[Any, ...]:
        lists = (self.leaves.tolist(), self.base.tolist(), self._handle.more())
        return (_restored, (self.tails, self.radii, self.parents, *lists))

    def __len__(self) -> int:
        return len(self._handle)

    def __repr__(self) -> str:
        return f"Plant({len(self)} segments, {int(self.leaves.sum())} of them on leaves)"


def _restored(*arrays: Any) -> Plant:
    return Plant(_catamaran.PlantHandle(*arrays))


def read_plant(
    path: Union[str, os.PathLike[str]],
    *,
    individual: Optional[str] = None,
    unit: Tuple[float, float] = (1.0, 1.0),
) -> Plant:
    """Reads a plant: .txt of the reference implementation, .swc, .mtg, polylines in .obj.

    A warning says what the file lacks, such as diameters, and what is assumed instead.

    Parameters
    ----------
    path : path
        Its ending names the format.
    individual : str, optional
        Which plant of an .mtg file of several, such as "P3".
    unit : (float, float)
        Metres in a unit of the file's lengths, and of its radii and diameters.
    """
    handle = _catamaran.read_plant(path, individual, unit)
    warn(path, handle.notes())
    return Plant(handle)


def grow_plant(nodes: int = 500, seed: int = 0) -> Plant:
    """Generates a plant of so many segments.

    Examples
    --------
    >>> import catamaran
    >>> len(catamaran.grow_plant(200))
    200
    """
    return Plant(_catamaran.grow(nodes, seed))


class Wilting:
    """What became of a plant, frame by frame.

    Attributes
    ----------
    plant : Plant
        The plant.
    hours : ndarray, frames
        When.
    full_water : ndarray, n
        Water of each segment when cells are full, in kg.
    water, moduli : ndarray, frames x n
        Water in kg and modulus of elasticity in Pa.
    balance : ndarray, frames x 5
        Water in the plant and in the soil, and what leaves have lost, what the soil has taken of
        the water poured on it, and what has drained since the beginning, in kg.
    heads, tails : ndarray, frames x n x 3
        The pose at rest, in metres.
    """

    def __init__(self, plant: Plant, found: Tuple[Any, ...]) -> None:
        self.plant = plant
        self.hours, self.full_water, self.water, self.moduli, self.balance, self._poses = found
        self.heads: NDArray[np.float64] = np.stack([pose[0] for pose in self._poses])
        self.tails: NDArray[np.float64] = np.stack([pose[1] for pose in self._poses])

    def mesh(self, frame: int, *, sides: int = 6, thinnest: float = 0.0) -> Mesh:
        """Returns vertices and faces of tubes around the segments in a frame."""
        pose = list(self._poses[frame])
        return Mesh(*_catamaran.tubes(self.plant._handle, pose, sides, thinnest))

    def plot(self, ax: Any = None) -> Any:
        """Draws the water of the plant over the hours, by matplotlib."""
        ax = axes(ax)
        ax.plot(self.hours, self.water.sum(axis=1))
        ax.set(xlabel="hours", ylabel="water in kg")
        return ax

    def __repr__(self) -> str:
        return f"Wilting({len(self.hours)} frames of {self.plant!r})"


def wilt(
    plant: Plant,
    hours: float = 48.0,
    *,
    frames: int = 24,
    loss: float = 60.0,
    day_night: bool = False,
    elasticity: Tuple[float, float] = (5e7, 3e5),
    steepness: float = 10.0,
    shift: float = 0.75,
    conductance: float = 1e-9,
    cut: Sequence[int] = (),
    weaken: Optional[Mapping[int, float]] = None,
    stomata: Optional[Sequence[float]] = None,
    soil: Optional[Union[float, Tuple[float, float]]] = None,
    rewater: Optional[Mapping[float, Optional[float]]] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Wilting:
    """Lets a plant dry out, and bend as it does.

    Parameters
    ----------
    plant : Plant
        Of `grow_plant` or `read_plant`.
    hours : float
        How long.
    frames : int
        Frames after the first one, at equal times.
    loss : float
        What leaves lose, in grams per hour and square metre.
    day_night : bool
        Whether leaves lose a twelfth of it for 8 of 24 hours.
    elasticity : (float, float)
        Modulus of elasticity of full cells and of dry ones, in Pa.
    steepness, shift : float
        Of the modulus as a function of the relative water content.
    conductance : float
        As a part of that of a pipe as wide as the segment.
    cut : sequence of int
        Segments whose connection to their parent is cut, for water.
    weaken : mapping of int to float, optional
        What the conductance of connections is multiplied by.
    stomata : (float, float) or (float, float, float), optional
        The relative water content at which stomata are half closed, and how abruptly they close:
        (0.8, 25) is usual. The third number is the loss through the cuticle as a part of `loss`,
        0 by default. Without `stomata` they stay open.
    soil : float or (float, float), optional
        What the soil holds of water that the root takes up, in grams, and what it has at first, by
        default as much as it holds.
    rewater : mapping of float to float or None, optional
        Grams of water that are poured on the soil after these hours, None for as much as it holds.
    threads, progress
        As in `ata`.

    Returns
    -------
    Wilting

    Examples
    --------
    >>> import catamaran
    >>> found = catamaran.wilt(catamaran.grow_plant(100), 24.0, frames=4)
    >>> found.water.shape
    (5, 100)
    >>> bool(found.water[-1].sum() < found.water[0].sum())
    True
    """
    if stomata is not None and len(stomata) not in (2, 3):
        raise ValueError(f"stomata: must be 2 or 3 numbers, is {stomata!r}")
    wet = (soil, soil) if isinstance(soil, (int, float)) else soil
    damage: List[Tuple[int, float]] = [(node, 0.0) for node in cut]
    damage.extend((weaken or {}).items())
    weather = {
        "hours": hours,
        "frames": frames,
        "loss": loss,
        "day_night": day_night,
        "conductance": conductance,
        "elasticity": elasticity,
        "steepness": steepness,
        "shift": shift,
        "damage": damage,
        "stomata": None if stomata is None else (*stomata, 0.0)[:3],
        "soil": wet,
        "rewater": list((rewater or {}).items()),
        "threads": threads,
    }
    return Wilting(plant, _catamaran.wilt(plant._handle, weather, callback(progress)))
