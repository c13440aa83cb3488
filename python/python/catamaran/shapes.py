"""Generated meshes: vertices (n x 3) and faces (m x 3).

>>> from catamaran import shapes
>>> v, f = shapes.icosphere(2)
>>> v.shape, f.shape
((162, 3), (320, 3))
"""

from __future__ import annotations

from typing import Sequence

from . import _catamaran
from ._surface import Mesh

__all__ = [
    "cylinder",
    "disk",
    "figure",
    "genus",
    "grid",
    "icosphere",
    "knot",
    "terrain",
    "torus",
]


def _shape(name: str, counts: Sequence[int], sizes: Sequence[float]) -> Mesh:
    return Mesh(*_catamaran.shape(name, counts, sizes))


def icosphere(subdivisions: int = 3) -> Mesh:
    """Returns a sphere of radius 1: an icosahedron, each face cut in four so many times."""
    return _shape("icosphere", [subdivisions], [])


def torus(around: int = 60, tube: int = 30, major: float = 2.0, minor: float = 0.8) -> Mesh:
    """Returns a torus of so many vertices around the axis and around the tube."""
    return _shape("torus", [around, tube], [major, minor])


def knot(p: int = 2, q: int = 3, along: int = 300, tube: int = 20, radius: float = 0.4) -> Mesh:
    """Returns a tube around a torus knot."""
    return _shape("knot", [p, q, along, tube], [radius])


def genus(genus: int = 2, cells: int = 8) -> Mesh:
    """Returns a block with so many holes."""
    return _shape("genus", [genus, cells], [])


def figure(cells: int = 24, pose: float = 0.0) -> Mesh:
    """Returns a figure with limbs, which `pose` bends."""
    return _shape("figure", [cells], [pose])


def grid(columns: int = 20, rows: int = 20) -> Mesh:
    """Returns a flat rectangle of so many cells."""
    return _shape("grid", [columns, rows], [])


def disk(rings: int = 10, sectors: int = 40) -> Mesh:
    """Returns a flat disk."""
    return _shape("disk", [rings, sectors], [])


def cylinder(around: int = 40, along: int = 20, radius: float = 1.0, height: float = 2.0) -> Mesh:
    """Returns a cylinder without lids."""
    return _shape("cylinder", [around, along], [radius, height])


def terrain(columns: int = 100, rows: int = 100, seed: int = 0) -> Mesh:
    """Returns hills."""
    return _shape("terrain", [columns, rows, seed], [])
