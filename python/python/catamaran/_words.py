"""The words that options take, as types: a type checker refuses others."""

from __future__ import annotations

from typing import Literal, Union

__all__ = [
    "Accuracy",
    "Boundary",
    "DistanceMethod",
    "FileFormat",
    "Gradient",
    "Kind",
    "MassKind",
    "MeshFormat",
    "Method",
    "MissingCells",
    "MissingRows",
    "Mode",
    "RankDeficiency",
    "Reduction",
    "Refinement",
    "Scheme",
    "Side",
    "Sums",
    "Triangle",
    "Weld",
]

#: A word, or the factor that errors may grow by.
Accuracy = Union[Literal["default", "max", "classical", "fast"], float]
Boundary = Literal["neumann", "dirichlet"]
DistanceMethod = Literal["heat", "exact", "edges"]
FileFormat = Literal["npy", "mtx", "table", "parquet", "arrow"]
Gradient = Literal["thesis", "shader"]
Kind = Literal["cotangent", "intrinsic", "tufted"]
MassKind = Literal["barycentric", "voronoi", "full"]
MeshFormat = Literal[
    "obj", "ply", "off", "stl", "glb", "gltf", "vtk", "vtp", "vtu", "gii", "white", "msh", "3mf"
]
#: How columns, and products of eigenfunctions, are orthogonalized.
Method = Literal["single_pass", "reorthogonalized", "rank_revealing"]
MissingCells = Literal["error", "drop", "nan"]
MissingRows = Literal["error", "drop"]
Mode = Literal["robust", "faithful"]
RankDeficiency = Literal["minimum_norm", "refuse"]
#: How a mesh is decimated.
Reduction = Literal["uniform", "thesis"]
Refinement = Literal["zoomout", "icp", "none"]
Scheme = Literal["auto", "float", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3", "exact"]
#: Which side of curves is inside.
Side = Literal["small", "large"]
#: What an accumulator sums in.
Sums = Literal["float", "exact", "extended"]
Triangle = Literal["both", "lower", "upper"]
#: Which vertices a repair joins.
Weld = Literal["never", "exact", "seams"]
