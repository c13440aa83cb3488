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
from ._curve import Curve, Curves, curve
from ._decimate import Decimated, FarthestPoints, Origin, decimate, farthest_points
from ._distance import ShortestPath, distances, shortest_path
from ._distribution import warn_of_other
from ._gram import SVD, LeastSquares, PrincipalComponents, lstsq, pca, svd
from ._mesh import Eigenpairs, Laplacian, eigsh, laplacian, read_mesh, write_mesh
from ._ortho import Orthonormal, orthogonality, orthogonalize, qr
from ._plant import Plant, Wilting, grow_plant, read_plant, wilt
from ._preload import numpy_speedup
from ._products import Accumulator, ata, corrcoef, cov, plan
from ._repair import Repaired, repair
from ._spectral import (
    Eigenbasis,
    Eigenproducts,
    FunctionalMap,
    ShapeFromSpectrum,
    eigenproducts,
    functional_map,
    shape_from_spectrum,
    transfer,
    transfer_details,
)
from ._surface import Mesh
from ._tables import Table, read
from ._texture import Fractal, Slime, newton, slime
from ._threadpool import register
from ._unions import UnionSpectrum, locate_union, shape_dna, union_spectrum

warn_of_other()
register()
del register, warn_of_other

__all__ = [
    "Accumulator",
    "Cholesky",
    "Curve",
    "Curves",
    "Decimated",
    "Eigenbasis",
    "Eigenpairs",
    "Eigenproducts",
    "FarthestPoints",
    "Fractal",
    "FunctionalMap",
    "Laplacian",
    "LeastSquares",
    "Mesh",
    "Origin",
    "Orthonormal",
    "Plan",
    "Plant",
    "PrincipalComponents",
    "Repaired",
    "SVD",
    "ShapeFromSpectrum",
    "ShortestPath",
    "Slime",
    "Table",
    "UnionSpectrum",
    "Wilting",
    "__version__",
    "ata",
    "cholesky",
    "corrcoef",
    "cov",
    "curve",
    "decimate",
    "distances",
    "eigenproducts",
    "eigsh",
    "farthest_points",
    "functional_map",
    "grow_plant",
    "laplacian",
    "locate_union",
    "lstsq",
    "newton",
    "numpy_speedup",
    "orthogonality",
    "orthogonalize",
    "pca",
    "plan",
    "qr",
    "read",
    "read_mesh",
    "read_plant",
    "repair",
    "shape_dna",
    "shape_from_spectrum",
    "shapes",
    "shortest_path",
    "slime",
    "svd",
    "transfer",
    "transfer_details",
    "union_spectrum",
    "wilt",
    "write_mesh",
]
