"""Eigenfunctions, their products, functional maps and transfer."""

from __future__ import annotations

from typing import Any, Callable, List, NamedTuple, Optional, Sequence, Tuple, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import (
    Progress,
    callback,
    part,
    to_nearest,
    to_scipy,
    warn_caller,
    warn_of_pieces,
)
from ._show import axes
from ._surface import Mesh, MeshLike, MeshOrArrays, mesh_arrays, takes_mesh, with_mesh
from ._words import Kind, Method, Refinement

__all__ = [
    "Eigenbasis",
    "Eigenproducts",
    "FunctionalMap",
    "ShapeFromSpectrum",
    "eigenproducts",
    "functional_map",
    "geodesic_rings",
    "product_map",
    "shape_from_spectrum",
    "shot",
    "transfer",
    "transfer_details",
]


class Eigenbasis(_catamaran.Eigenbasis):
    """The first eigenfunctions of the Laplacian of a mesh, for the functions of this chapter.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    k : int
        Eigenfunctions, the constant one included; at least one for each component of the mesh.
    kind : {"cotangent", "intrinsic", "tufted"}
        As in `laplacian`.
    weld : bool
        As in `eigsh`; vertices that are joined share their mass.
    threads, progress
        As in `ata`.

    Attributes
    ----------
    values : ndarray of k numbers
        Eigenvalues, ascending.
    functions : ndarray, n x k
        Orthonormal in the inner product of the mass; the first one is constant.
    mass : scipy.sparse.csr_array
        The inner product.

    Examples
    --------
    >>> import catamaran
    >>> basis = catamaran.Eigenbasis(*catamaran.shapes.icosphere(3), 5)
    >>> basis.functions.shape
    (642, 5)
    >>> smooth = basis.filter(catamaran.shapes.icosphere(3).v, lambda x: x < 3)
    """

    def __new__(
        cls,
        v: Union[ArrayLike, MeshLike],
        f: Optional[ArrayLike] = None,
        k: int = 31,
        *,
        kind: Kind = "cotangent",
        weld: bool = False,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Eigenbasis:
        mesh = mesh_arrays(v)
        if mesh is not None:
            if f is not None:
                raise TypeError("f: not together with a mesh: Eigenbasis(mesh, k=...)")
            v, f = mesh
        parts = _catamaran.eigenbasis(v, f, k, kind, weld, threads, callback(progress))
        basis = super().__new__(cls, *parts)
        warn_of_pieces(basis._pieces, dirichlet=False, shifted=False, name="")
        return basis

    @property
    def mass(self) -> Any:
        """The inner product."""
        return to_scipy(self._mass())

    def __reduce__(self) -> Tuple[Any, ...]:
        # The mass is a diagonal.
        masses = self._mass()[0]
        return (_restored, (self.values, self.functions, masses, self._pieces))

    def filter(
        self,
        functions: ArrayLike,
        gain: Callable[[NDArray[np.float64]], ArrayLike],
        rest: float = 0.0,
        *,
        threads: Optional[int] = None,
    ) -> NDArray[np.float64]:
        """Multiplies the coefficients of functions.

        Parameters
        ----------
        functions : array_like, n x c, or n numbers
            Functions on the vertices, such as coordinates.
        gain : callable
            Returns the factor of each coefficient, given the eigenvalues: ``lambda x: x < 3`` is a
            low-pass filter, and ``lambda x: np.exp(-t * x)`` the diffusion of heat for a time t.
        rest : float
            The factor of what is left of the functions outside of the basis.
        threads
            As in `ata`.

        Returns
        -------
        ndarray, of the shape of `functions`
        """
        gains = np.asarray(gain(self.values), dtype=np.float64)
        found = self._filter(functions, gains, rest, threads)
        return found[:, 0] if np.ndim(functions) == 1 else found

    @to_nearest
    def split(
        self, functions: ArrayLike, *, threads: Optional[int] = None
    ) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Returns the nearest functions in the basis, and the details: what is left of them."""
        low = self.filter(functions, np.ones_like, threads=threads)
        return low, np.asarray(functions) - low

    def add_coefficient(
        self, functions: ArrayLike, index: int, amount: float
    ) -> NDArray[np.float64]:
        """Returns functions (n x c, or n numbers) with `amount` more of the coefficient of the
        function `index` of the basis, from 0: that many times the function is added to each."""
        found = self._add_coefficient(functions, index, amount)
        return found[:, 0] if np.ndim(functions) == 1 else found

    def global_point_signature(self) -> NDArray[np.float64]:
        """Computes the global point signature (Rustamov 2007): the functions over the roots of
        their eigenvalues, a column for each one that is not 0; without unit."""
        return self._point_signature()

    def heat_kernel_signature(
        self,
        count: int = 100,
        *,
        times: Optional[ArrayLike] = None,
        threads: Optional[int] = None,
    ) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Computes heat kernel signatures (Sun, Ovsjanikov and Guibas 2009).

        Parameters
        ----------
        count : int
            Times, from 4 ln 10 over the largest eigenvalue to 4 ln 10 over the smallest one that is
            not 0, in equal ratios; for no `times`.
        times : array_like, optional
            Other times, in units of length^2.
        threads
            As in `ata`.

        Returns
        -------
        signatures : ndarray, n x count
            In units of 1 / area.
        times : ndarray of count numbers
        """
        return self._heat_signature(times, count, threads)

    def wave_kernel_signature(
        self, count: int = 100, *, threads: Optional[int] = None
    ) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Computes wave kernel signatures (Aubry, Schlickewei and Cremers 2011).

        Parameters
        ----------
        count : int
            Energies: logarithms of eigenvalues.
        threads
            As in `ata`.

        Returns
        -------
        signatures : ndarray, n x count
            In units of 1 / area.
        energies : ndarray of count numbers
        """
        return self._wave_signature(count, threads)

    def __repr__(self) -> str:
        return f"Eigenbasis({len(self)} functions)"


def _restored(*parts: Any) -> Eigenbasis:
    return _catamaran.Eigenbasis.__new__(Eigenbasis, *parts)


#: What functions take: a basis, vertices and faces, or a mesh.
Shape = Union[Eigenbasis, MeshOrArrays]


#: The part of the progress of a call that a basis takes.
_SHARE = 0.3


def _bases(
    shapes: Sequence[Shape],
    lens: Sequence[int],
    weld: bool,
    threads: Optional[int],
    progress: Progress,
) -> Tuple[List[Eigenbasis], Progress]:
    """Returns a basis of each shape, and the progress of what is computed with them."""
    bases: List[Eigenbasis] = []
    start = 0.0
    for shape, k in zip(shapes, lens):
        if isinstance(shape, Eigenbasis):
            bases.append(shape)
            continue
        v, f = mesh_arrays(shape) or cast(Tuple[Any, Any], shape)
        of_basis = part(progress, start, start + _SHARE)
        bases.append(Eigenbasis(v, f, k, weld=weld, threads=threads, progress=of_basis))
        start += _SHARE
    return bases, part(progress, start, 1.0)


class Eigenproducts(NamedTuple):
    """A basis of `eigenproducts`."""

    #: n x r: orthonormal functions.
    functions: NDArray[np.float64]
    #: r x products: coefficients of all products.
    r: NDArray[np.float64]
    #: The products that the basis is made of.
    kept: NDArray[Any]
    #: The factors of each of these, from 1, such as [1, 1] for the square of the first
    #: eigenfunction that is not constant; [] is the constant.
    factors: List[List[int]]


@with_mesh
def eigenproducts(
    v: Any,
    f: Any = None,
    k: int = 30,
    order: int = 2,
    *,
    method: Method = "single_pass",
    kind: Kind = "cotangent",
    weld: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Eigenproducts:
    """Computes a basis of the products of at most `order` eigenfunctions.

    ``eigenproducts(v, f, k, order)`` takes a mesh, ``eigenproducts(basis, order=order)`` an
    `Eigenbasis`.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    k : int
        Eigenfunctions that are multiplied, the constant one not counted; all those of an
        `Eigenbasis`.
    order : int
        Factors of a product, at most.
    method : {"single_pass", "reorthogonalized", "rank_revealing"}
        How products are orthogonalized: once, the stabler one under transfer; until they are
        orthogonal to rounding, the larger one; or by numerical rank.
    kind : {"cotangent", "intrinsic", "tufted"}
        As in `laplacian`.
    weld : bool
        As in `Eigenbasis`.
    threads, progress
        As in `ata`.

    Returns
    -------
    Eigenproducts

    Examples
    --------
    >>> import catamaran
    >>> found = catamaran.eigenproducts(*catamaran.shapes.icosphere(3), k=3, order=2)
    >>> found.factors[:6]
    [[], [1], [2], [3], [1, 1], [1, 2]]
    """
    if isinstance(v, Eigenbasis):
        if f is not None:
            raise TypeError("f: not together with a basis: eigenproducts(basis, order=...)")
        basis, rest = v, progress
    else:
        of_basis, rest = part(progress, 0.0, _SHARE), part(progress, _SHARE, 1.0)
        basis = Eigenbasis(v, f, k + 1, kind=kind, weld=weld, threads=threads, progress=of_basis)
    found = _catamaran.eigenproducts(basis, order, method, threads, callback(rest))
    return Eigenproducts(*found)


class FunctionalMap(NamedTuple):
    """A map of `functional_map`."""

    #: k_target x k_source: coefficients on the target of functions on the source.
    map: NDArray[np.float64]
    #: The corresponding vertex of the source for each vertex of the target.
    points: NDArray[Any]

    def plot(self, ax: Any = None) -> Any:
        """Draws the sizes of the coefficients by matplotlib."""
        ax = axes(ax)
        ax.imshow(np.abs(self.map))
        ax.set(xlabel="function of the source", ylabel="function of the target")
        return ax


def _searched(shapes: Tuple[Shape, Shape]) -> Optional[Tuple[Any, Any]]:
    """Returns the arrays of two meshes; None where one of them is a basis."""
    if any(isinstance(shape, Eigenbasis) for shape in shapes):
        return None
    source, target = (mesh_arrays(shape) or shape for shape in shapes)
    return source, target


def functional_map(
    source: Shape,
    target: Shape,
    *,
    landmarks: Optional[ArrayLike] = None,
    functions: Optional[Tuple[ArrayLike, ArrayLike]] = None,
    k: Union[int, Tuple[int, int]] = 30,
    zoom: int = 100,
    signatures: bool = True,
    commutativity: float = 1e-3,
    refine: Refinement = "zoomout",
    weld: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> FunctionalMap:
    """Finds which functions and vertices of two meshes correspond.

    Without landmarks and functions, the map between two meshes is searched for: the one that
    commutes best with the Laplacians and keeps left and right. A warning tells where another map
    may be the true one.

    Parameters
    ----------
    source, target : (v, f), a mesh or Eigenbasis
        The meshes. Bases of (v, f) have k + 1 functions, or `zoom` for "zoomout". For an Eigenbasis
        there is no search: without landmarks and functions, the map is fitted to signatures alone,
        which don't tell left from right, and a warning says so.
    landmarks : array_like, count x 2, optional
        Corresponding vertices.
    functions : (array_like, array_like), optional
        Corresponding functions, a column each.
    k : int or (int, int)
        Eigenfunctions of source and target that are fitted, the constant one not counted.
    zoom : int
        Eigenfunctions that refinement by "zoomout" ends with.
    signatures : bool
        Whether heat and wave kernel signatures are fitted, too.
    commutativity : float
        Weight of the commutativity with the Laplacians.
    refine : {"zoomout", "icp", "none"}
        How the map is refined.
    weld : bool
        As in `Eigenbasis`, for meshes.
    threads, progress
        As in `ata`.

    Returns
    -------
    FunctionalMap
        ``map``, ``points``.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> shape = catamaran.shapes.figure(16)
    >>> pairs = np.array([[0, 0], [100, 100], [200, 200], [300, 300]])
    >>> found = catamaran.functional_map(shape, shape, landmarks=pairs, k=15, refine="none")
    >>> found.map.shape
    (16, 16)
    """
    both = (k, k) if isinstance(k, (int, np.integer)) else k
    lens = (both[0] + 1, both[1] + 1)
    more = [max(n, zoom) if refine == "zoomout" else n for n in lens]
    bases, rest = _bases((source, target), more, weld, threads, progress)
    is_unknown = landmarks is None and functions is None
    meshes = _searched((source, target)) if is_unknown else None
    map, points, doubt = _catamaran.functional_map(
        bases[0],
        bases[1],
        meshes,
        lens,
        landmarks,
        functions,
        signatures,
        commutativity,
        refine,
        threads,
        callback(rest),
    )
    if is_unknown and meshes is None:
        doubt = "an Eigenbasis has no faces to search by, and signatures don't tell left from right"
    if doubt is not None:
        warn_caller(f"{doubt}: check the result, or give landmarks")
    return FunctionalMap(map, points)


def product_map(
    source: Eigenbasis,
    target: Eigenbasis,
    map: ArrayLike,
    *,
    order: int = 2,
    method: Method = "single_pass",
    all_products: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Extends a functional map to orthogonal products of eigenfunctions (thesis, section 1.3.3).

    The image of a product is the product of the images. The matrix of all products is never
    stored. The map must be exact, or nearly so: the error grows fast otherwise, where `transfer`,
    which goes through corresponding points, is stable.

    Parameters
    ----------
    source, target : Eigenbasis
        At least as many functions as the map has columns and rows.
    map : array_like, k_target x k_source
        As of `functional_map`, the constant functions included.
    order : int
        Factors of a product, at most.
    method
        As in `eigenproducts`, whose functions on source and target the result maps.
    all_products : bool
        Whether every product has a part in the result by least squares (equation 1.16); otherwise
        only those that the basis of the source is made of (equation 1.18).
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, r_target x r_source

    Raises
    ------
    ValueError
        Names a shape that does not fit, or a basis without the constant function.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> basis = catamaran.Eigenbasis(catamaran.shapes.icosphere(2), k=4)
    >>> found = catamaran.product_map(basis, basis, np.eye(4))  # the identity
    >>> bool(np.allclose(found, np.eye(len(found))))
    True
    """
    return _catamaran.product_map(
        source, target, map, order, method, all_products, threads, callback(progress)
    )


@takes_mesh
def shot(
    v: ArrayLike,
    f: ArrayLike,
    radius: float,
    *,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Computes SHOT descriptors (Tombari, Salti and Di Stefano 2010): histograms of normals in the
    parts of a ball around each vertex.

    They stay the same under rigid motions, and under scaling together with the radius.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    radius : float
        Of the ball, in units of length; positive.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, n x 352
        Rows of norm 1; zero for a vertex with fewer than five others in its ball.

    Examples
    --------
    >>> import catamaran
    >>> catamaran.shot(catamaran.shapes.icosphere(2), 0.6).shape
    (162, 352)
    """
    return _catamaran.shot(v, f, radius, threads, callback(progress))


@takes_mesh
def geodesic_rings(
    v: ArrayLike,
    f: ArrayLike,
    functions: ArrayLike,
    radius: float,
    rings: int,
    *,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Computes means of functions over rings of distance along edges around each vertex.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces.
    functions : array_like, n x c, or n numbers
        Such as heat kernel signatures.
    radius : float
        Of the last ring, in units of length; positive.
    rings : int
        Rings, at least 1.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, n x (rings (1 + c))
        For each ring from the middle out, its share of the area of all, then the means.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> mesh = catamaran.shapes.icosphere(2)
    >>> found = catamaran.geodesic_rings(mesh, np.ones(len(mesh.v)), 0.5, 2)
    >>> bool(np.allclose(found[:, [1, 3]], 1) and np.allclose(found[:, 0] + found[:, 2], 1))
    True
    """
    return _catamaran.geodesic_rings(v, f, functions, radius, rings, threads, callback(progress))


def transfer(
    source: Shape,
    target: Shape,
    functions: ArrayLike,
    *,
    points: Optional[ArrayLike] = None,
    k: Union[int, Tuple[int, int]] = 30,
    order: int = 2,
    method: Method = "single_pass",
    weld: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Transfers functions from a mesh to another one, through products of eigenfunctions.

    Parameters
    ----------
    source, target : (v, f), a mesh or Eigenbasis
        The meshes.
    functions : array_like, n_source x c, or n_source numbers
        Functions on the source.
    points : array_like of n_target vertices, optional
        The corresponding vertex of the source for each of the target, as of `functional_map`; by
        default vertices of the same number correspond.
    k : int or (int, int)
        Eigenfunctions that are multiplied, the constant one not counted.
    order : int
        Factors of a product, at most; 1 transfers through eigenfunctions alone.
    method
        As in `eigenproducts`.
    weld : bool
        As in `Eigenbasis`, for meshes.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, n_target x c, or n_target numbers

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> v, f = catamaran.shapes.icosphere(3)
    >>> g = catamaran.transfer((v, f), (2 * v, f), v[:, 2], k=8)
    >>> bool(np.abs(g - v[:, 2]).max() < 0.01)
    True
    """
    both = (k, k) if isinstance(k, (int, np.integer)) else k
    lens = (both[0] + 1, both[1] + 1)
    bases, rest = _bases((source, target), lens, weld, threads, progress)
    if points is None:
        points = np.arange(bases[1].functions.shape[0])
    found = _catamaran.transfer(
        bases[0], bases[1], functions, points, lens, order, method, threads, callback(rest)
    )
    return found[:, 0] if np.ndim(functions) == 1 else found


def transfer_details(
    source: MeshOrArrays,
    target: MeshOrArrays,
    *,
    points: Optional[ArrayLike] = None,
    smooth: int = 20,
    k: Union[int, Tuple[int, int]] = 30,
    order: int = 2,
    method: Method = "single_pass",
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Mesh:
    """Gives a mesh the details of another one, in its own pose.

    Details are the heights of the source over its smooth part, along the normals of that part; they
    replace those of the target.

    Parameters
    ----------
    source, target : (v, f), or a mesh
        The meshes.
    smooth : int
        Eigenfunctions that the smooth parts are made of, the constant one not counted.
    points, k, order, method
        As in `transfer`, which carries the heights.
    threads, progress
        As in `ata`.

    Returns
    -------
    Mesh
        The target with other vertices.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> v, f = catamaran.shapes.icosphere(2)
    >>> found = catamaran.transfer_details((v, f), (v, f), smooth=3, k=8)
    >>> bool(np.abs(found.v - v).max() < 0.05)
    True
    """
    both = (k, k) if isinstance(k, (int, np.integer)) else k
    lens = (both[0] + 1, both[1] + 1)
    meshes = [mesh_arrays(mesh) or cast(Tuple[Any, Any], mesh) for mesh in (source, target)]
    more = [max(n, smooth + 1) for n in lens]
    bases, rest = _bases(meshes, more, False, threads, progress)
    if points is None:
        points = np.arange(bases[1].functions.shape[0])
    found = _catamaran.transfer_details(
        meshes[0],
        meshes[1],
        bases[0],
        bases[1],
        smooth + 1,
        points,
        lens,
        order,
        method,
        threads,
        callback(rest),
    )
    return Mesh(*found)


class ShapeFromSpectrum(NamedTuple):
    """A mesh of `shape_from_spectrum`."""

    #: The template with other vertices.
    mesh: Mesh
    #: Its first eigenvalues.
    values: NDArray[np.float64]
    #: Their mean relative difference from those that were wanted.
    error: float
    #: How many steps were taken.
    steps: int


@takes_mesh
def shape_from_spectrum(
    v: ArrayLike,
    f: ArrayLike,
    values: ArrayLike,
    *,
    steps: int = 60,
    tolerance: float = 1e-3,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> ShapeFromSpectrum:
    """Deforms a template until the first eigenvalues of its Laplacian are those given.

    Many surfaces have the same eigenvalues: the result is one near the template, or falls short of
    the tolerance.

    Parameters
    ----------
    v, f : array_like, n x 3 and m x 3
        Vertices and faces of the template.
    values : array_like of k numbers
        Positive and ascending; those with Dirichlet boundary values, or, if the template is closed,
        those that are not 0.
    steps : int
        Steps, at most.
    tolerance : float
        The mean relative difference at which the deformation ends.
    threads, progress
        As in `ata`.

    Returns
    -------
    ShapeFromSpectrum

    Examples
    --------
    >>> import catamaran
    >>> v, f = catamaran.shapes.icosphere(2)
    >>> wanted = [2, 2, 2, 6, 6, 6, 6, 6]  # of a sphere
    >>> found = catamaran.shape_from_spectrum(v * [1, 1.1, 1.2], f, wanted, tolerance=0.01)
    >>> found.error <= 0.01
    True
    """
    mesh, eigenvalues, error, count = _catamaran.shape_from_spectrum(
        v, f, values, steps, tolerance, threads, callback(progress)
    )
    return ShapeFromSpectrum(Mesh(*mesh), eigenvalues, error, count)
