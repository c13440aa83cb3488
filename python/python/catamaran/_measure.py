"""What is known about meshes: problems, differences and quality."""

from __future__ import annotations

from typing import List, NamedTuple, Optional, Tuple

__all__ = ["Comparison", "OneSided", "Quality", "Validation"]


class Validation(NamedTuple):
    """Counts and problems of a mesh, of `Mesh.validate`; ``print`` shows them."""

    #: Numbers of vertices, edges, faces and components.
    vertices: int
    edges: int
    faces: int
    components: int
    #: Edges with one face.
    boundary_edges: int
    #: Loops of the boundary; None where edges of many faces leave them undefined.
    boundary_loops: Optional[int]
    #: V - E + F, without vertices in no face.
    euler_characteristic: int
    #: Handles, or cross-caps of a mesh that is not orientable; None if it is not a manifold.
    genus: Optional[int]
    #: Whether faces can be flipped so that all agree about the side that is outside.
    is_orientable: bool
    #: The kind of each problem, and the vertex, edge or face that has it.
    problems: List[Tuple[str, str]]
    #: Why functions of spectra would be wrong without `repair`; None if they are not.
    needs_repair: Optional[str]
    #: All of it in lines of text.
    report: str

    def __str__(self) -> str:
        return self.report


class OneSided(NamedTuple):
    """Distances from one surface to another one."""

    #: The largest distance of its vertices and of points spread over it, in units of length.
    largest: float
    #: The mean distance of these points, in units of length.
    mean: float
    #: The mean angle between its normals and those of the nearest points, 0 to 180 degrees.
    angle: float


class Comparison(NamedTuple):
    """Distances between two surfaces, of `Mesh.compare`."""

    #: From the first mesh to the second one.
    out: OneSided
    #: From the second mesh to the first one.
    back: OneSided


class Quality(NamedTuple):
    """How uniform a mesh is, of `Mesh.quality` (thesis, section 5.4.1)."""

    #: The mean area of faces, in units of area.
    mean_area: float
    #: The standard deviation of areas over their mean.
    area_variation: float
    #: Mean, standard deviation and least of the qualities of faces, as of `Mesh.qualities`.
    mean_quality: float
    quality_deviation: float
    least_quality: float
    #: The mean number of edges at a vertex.
    mean_valence: float
    #: The share of vertices with 6 edges, or 4 on the boundary, from 0 to 1.
    regular_vertices: float
    #: Edges of more than two faces.
    non_manifold_edges: int
