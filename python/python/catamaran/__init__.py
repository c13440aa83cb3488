"""A^T A, spectra and geometry at scale.

Matrices are numpy arrays of any strides. Meshes are pairs of arrays, vertices (n x 3) and faces
(m x 3), or those of trimesh, meshio and pyvista. Long calls release the interpreter, end by Ctrl-C,
and tell their progress to a callable or a progress bar of tqdm. Results do not depend on the number
of threads, bit for bit.

>>> import numpy as np
>>> import catamaran
>>> catamaran.ata(np.array([[1.0, 2.0], [3.0, 4.0]]))
array([[10., 14.],
       [14., 20.]])
"""

from . import shapes
from ._catamaran import Plan, __version__
from ._cholesky import Cholesky, cholesky
from ._curve import Curve, Curves, Drawn, Placed, curve, draw, place
from ._decimate import Decimated, Difference, FarthestPoints, Origin, decimate, farthest_points
from ._distance import (
    GeodesicPath,
    GeodesicTrace,
    ShortestPath,
    distances,
    geodesic_path,
    shortest_path,
    trace_geodesic,
)
from ._distribution import warn_of_other
from ._gram import SVD, LeastSquares, PrincipalComponents, lstsq, pca, svd
from ._isosurface import isosurface, label_surface
from ._measure import Comparison, OneSided, Quality, Validation
from ._mesh import (
    Eigenpairs,
    Laplacian,
    cloud_laplacian,
    count_below,
    dirichlet_energies,
    divergence,
    eigsh,
    free_components,
    gradient,
    laplacian,
    mesh_from_bytes,
    mesh_to_bytes,
    read_mesh,
    read_scalars,
    write_mesh,
)
from ._ortho import Orthonormal, orthogonality, orthogonalize, qr
from ._plant import Plant, Wilting, grow_plant, read_plant, wilt
from ._preload import numpy_speedup
from ._products import Accumulator, Verification, ata, corrcoef, cov, plan, verify
from ._regions import cut, enclosed_faces, region_boundary
from ._repair import Repaired, repair
from ._spectral import (
    Eigenbasis,
    Eigenproducts,
    FunctionalMap,
    ShapeFromSpectrum,
    eigenproducts,
    functional_map,
    geodesic_rings,
    product_map,
    shape_from_spectrum,
    shot,
    transfer,
    transfer_details,
)
from ._surface import Mesh, Part, Refined
from ._tables import Table, read
from ._texture import Fractal, Slime, newton, slime
from ._threadpool import register
from ._unions import (
    RetrievalMetric,
    UnionSpectrum,
    interpolate_spectra,
    locate_union,
    shape_dna,
    union_spectrum,
)

warn_of_other()
register()
del register, warn_of_other

__all__ = [
    "Accumulator",
    "Cholesky",
    "Comparison",
    "Curve",
    "Curves",
    "Decimated",
    "Difference",
    "Drawn",
    "Eigenbasis",
    "Eigenpairs",
    "Eigenproducts",
    "FarthestPoints",
    "Fractal",
    "FunctionalMap",
    "GeodesicPath",
    "GeodesicTrace",
    "Laplacian",
    "LeastSquares",
    "Mesh",
    "OneSided",
    "Origin",
    "Orthonormal",
    "Part",
    "Placed",
    "Plan",
    "Plant",
    "PrincipalComponents",
    "Quality",
    "Refined",
    "Repaired",
    "RetrievalMetric",
    "SVD",
    "ShapeFromSpectrum",
    "ShortestPath",
    "Slime",
    "Table",
    "UnionSpectrum",
    "Validation",
    "Verification",
    "Wilting",
    "__version__",
    "ata",
    "cholesky",
    "cloud_laplacian",
    "corrcoef",
    "count_below",
    "cov",
    "curve",
    "cut",
    "decimate",
    "dirichlet_energies",
    "distances",
    "divergence",
    "draw",
    "eigenproducts",
    "eigsh",
    "enclosed_faces",
    "farthest_points",
    "free_components",
    "functional_map",
    "geodesic_path",
    "geodesic_rings",
    "gradient",
    "grow_plant",
    "interpolate_spectra",
    "isosurface",
    "label_surface",
    "laplacian",
    "locate_union",
    "lstsq",
    "mesh_from_bytes",
    "mesh_to_bytes",
    "newton",
    "numpy_speedup",
    "orthogonality",
    "orthogonalize",
    "pca",
    "place",
    "plan",
    "product_map",
    "qr",
    "read",
    "read_mesh",
    "read_plant",
    "read_scalars",
    "region_boundary",
    "repair",
    "shape_dna",
    "shape_from_spectrum",
    "shapes",
    "shortest_path",
    "shot",
    "slime",
    "svd",
    "trace_geodesic",
    "transfer",
    "transfer_details",
    "union_spectrum",
    "verify",
    "wilt",
    "write_mesh",
]
