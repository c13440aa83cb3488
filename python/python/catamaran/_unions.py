"""Signatures of shapes, and spectra of unions of parts."""

from __future__ import annotations

import os
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, warn_of_pieces
from ._surface import mesh_arrays, takes_mesh
from ._words import Kind

__all__ = [
    "RetrievalMetric",
    "UnionSpectrum",
    "interpolate_spectra",
    "locate_union",
    "shape_dna",
    "union_spectrum",
]


@takes_mesh
def shape_dna(
    v: ArrayLike,
    f: ArrayLike,
    k: int = 20,
    *,
    normalized: bool = True,
    kind: Kind = "cotangent",
    weld: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Computes the first eigenvalues of the Laplacian: a signature of the shape that does not
    depend on its pose.

    As many of them are zero as the mesh has components: a warning says so where there are several.

    Parameters
    ----------
    v, f : array_like
        Vertices and faces.
    k : int
        Eigenvalues, more than the mesh has components.
    normalized : bool
        Whether they are multiplied by the area, so that the size does not count.
    kind : {"cotangent", "intrinsic", "tufted"}
        As in `laplacian`.
    weld : bool
        Whether vertices with equal positions are joined, as along the seams of a texture.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray of k numbers

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> v, f = catamaran.shapes.torus()
    >>> one, other = catamaran.shape_dna(v, f, 5), catamaran.shape_dna(3 * v, f, 5)
    >>> bool(np.allclose(one, other))
    True
    """
    values, pieces = _catamaran.shape_dna(
        v, f, k, normalized, kind, weld, threads, callback(progress)
    )
    warn_of_pieces(pieces, dirichlet=False, shifted=False, name="")
    return values


class RetrievalMetric:
    """A distance between spectra that is small for two poses of one shape, as `fit` makes it.

    It is the Mahalanobis distance of the logarithms of eigenvalues, given the covariances of poses,
    of shapes and of errors of predicted queries (docs/algorithms/unions.md).
    """

    def __init__(self, handle: _catamaran.MetricHandle) -> None:
        self._handle = handle

    @classmethod
    def fit(
        cls,
        spectra: ArrayLike,
        identities: Sequence[Any],
        *,
        errors: Optional[ArrayLike] = None,
        zeros: int = 1,
        scale_free: bool = False,
        shrinkage: float = 0.5,
        poses_only: bool = False,
        spectrum: str = "",
    ) -> RetrievalMetric:
        """Fits a metric to spectra of shapes, some of which have several poses.

        Parameters
        ----------
        spectra : array_like, a row of k eigenvalues for each shape in a pose
            As `shape_dna` returns them.
        identities : sequence
            The name or number of the shape of each row.
        errors : array_like, a row of k - zeros numbers for each prediction, optional
            Logarithms of the last predicted eigenvalues minus those of the true ones, where queries
            are predicted spectra.
        zeros : int
            Eigenvalues at the start of each spectrum that are zero and left out: one for each
            component without a vertex that is held at zero.
        scale_free : bool
            Whether shapes that differ only in size count as the same.
        shrinkage : float
            Share of the covariance of errors, from 0 to 1, that is replaced by their mean variance.
        poses_only : bool
            Whether the differences of shapes are taken as much larger than those of poses, instead
            of estimated.
        spectrum : str
            What the eigenvalues are, in words that the file of the metric keeps.

        Returns
        -------
        RetrievalMetric

        Raises
        ------
        ValueError
            For fewer than 2 p + 3 shapes, where p = k - zeros, unless `poses_only`: the covariance
            of fewer makes new shapes seem impossible. Without errors, shapes need p poses beside
            the first one of each.

        Examples
        --------
        >>> import catamaran
        >>> spectra = [[0, 2, 5], [0, 2.02, 6], [0, 3, 5.5], [0, 3.01, 7]]
        >>> metric = catamaran.RetrievalMetric.fit(spectra, ["a", "a", "b", "b"], poses_only=True)
        >>> int(metric.distances([[0, 2.01, 7]], spectra).argmin()) < 2
        True
        """
        numbers = np.unique(np.asarray(identities), return_inverse=True)[1]
        handle = _catamaran.MetricHandle(
            spectra,
            numbers.ravel().tolist(),
            errors,
            zeros,
            scale_free,
            shrinkage,
            poses_only,
            spectrum,
        )
        return cls(handle)

    @classmethod
    def load(cls, path: Union[str, os.PathLike[str]]) -> RetrievalMetric:
        """Reads a metric that `save` or ``catamaran shapedna --fit-metric`` wrote."""
        return cls(_catamaran.MetricHandle.read(path))

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the metric to a file in JSON, which is replaced if it exists."""
        self._handle.write(path)

    def distances(self, queries: ArrayLike, shapes: ArrayLike) -> NDArray[np.float64]:
        """Computes the distance of each query from each shape.

        Parameters
        ----------
        queries, shapes : array_like, a row of k eigenvalues for each

        Returns
        -------
        ndarray, a row for each query and a column for each shape
            About the square root of k - zeros where both are poses of one shape. A distance is not
            that of the two in exchanged roles.
        """
        return self._handle.distances(queries, shapes)

    @property
    def k(self) -> int:
        """Number of eigenvalues of the spectra."""
        return self._handle.k

    @property
    def spectrum(self) -> str:
        """What the eigenvalues are, in the words of `fit`."""
        return self._handle.spectrum

    def __repr__(self) -> str:
        return f"RetrievalMetric(k={self.k}, spectrum={self.spectrum!r})"

    def __reduce__(self) -> Tuple[Any, ...]:
        return _metric_of, (self._handle.to_bytes(),)


def _metric_of(content: bytes) -> RetrievalMetric:
    """Returns the metric of the bytes of a file."""
    return RetrievalMetric(_catamaran.MetricHandle.from_bytes(content))


class UnionSpectrum(NamedTuple):
    """What `union_spectrum` predicts."""

    #: The first 20 Dirichlet eigenvalues of the union.
    union: NDArray[np.float64]
    #: Those of the parts.
    parts: List[NDArray[np.float64]]
    #: How unlike the training the parts are; above 1 they are further out than 99.5 % of its pairs,
    #: and the prediction is a guess. Below 1 the prediction may be wrong, too.
    ood_score: float


def union_spectrum(
    parts: Sequence[Any],
    *,
    model: Union[str, os.PathLike[str], None] = None,
    weld: bool = False,
    progress: Progress = None,
) -> UnionSpectrum:
    """Predicts the spectrum of the union of parts of a surface, wherever the parts are.

    Parameters
    ----------
    parts : sequence of (v, f), of meshes, or of 20 eigenvalues
        The parts, at least two: meshes of which each component has a boundary, or their first 20
        Dirichlet eigenvalues.
    model : path, optional
        Weights, as ``catamaran unions train`` writes them; those that come with the library by
        default (docs/model-card-unions.md says what they are good for).
    weld : bool
        As in `shape_dna`, for meshes.
    progress
        As in `ata`.

    Returns
    -------
    UnionSpectrum
        ``union``, ``parts``, ``ood_score``.

    Warns
    -----
    UserWarning
        Names a part, numbered from 0, of several components, or with vertices in no face.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> v, f = catamaran.shapes.disk(20, 60)
    >>> found = catamaran.union_spectrum([(v, f), (v * 0.8, f)])
    >>> bool(np.all(found.union <= found.parts[0]))  # a larger domain has smaller eigenvalues
    True
    """
    union, spectra, pieces, ood_score = _catamaran.union_spectrum(
        listed(parts), model, weld, callback(progress)
    )
    warn_of_parts(pieces)
    return UnionSpectrum(union, spectra, ood_score)


def interpolate_spectra(first: ArrayLike, second: ArrayLike, t: float) -> NDArray[np.float64]:
    """Returns the spectrum ``(1 - t) first + t second`` between two spectra of parts, of which
    `union_spectrum` and `shape_from_spectrum` make unions and shapes (thesis, section 2.6.2).

    Parameters
    ----------
    first, second : array_like of 20 eigenvalues
        Positive and ascending, in units of 1 / length^2.
    t : float
        From 0 to 1.

    Returns
    -------
    ndarray of 20 numbers

    Raises
    ------
    ValueError
        Names a spectrum that is not 20 positive numbers in ascending order, or `t`.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> one = 40.0 * np.arange(1, 21)
    >>> catamaran.interpolate_spectra(one, 2 * one, 0.5)[:2]
    array([ 60., 120.])
    """
    return _catamaran.interpolate_spectra(first, second, t)


def listed(parts: Sequence[Any]) -> List[Any]:
    """Returns parts as the extension takes them."""
    return [mesh_arrays(part) or part for part in parts]


def warn_of_parts(pieces: Sequence[Optional[Tuple[int, int, int, int, int]]]) -> None:
    """Warns of parts of several components, with vertices in no face, or with repeated faces."""
    for i, of_part in enumerate(pieces):
        if of_part is not None:
            warn_of_pieces(of_part, dirichlet=False, shifted=False, name=f"part {i}")


def locate_union(
    parts: Sequence[Any],
    template: Any,
    *,
    model: Union[str, os.PathLike[str], None] = None,
    weld: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Finds where the union of parts of a human is on the template of the network.

    Parameters
    ----------
    parts, model, weld
        As in `union_spectrum`.
    template : (v, f), or a mesh
        The mesh that ``catamaran unions template`` writes. Another one is a ValueError.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, a number for each vertex of the template
        About 1 inside of the union and 0 outside; the union is what is above 1/2. Mirror images
        have the same spectrum: it is one of the two.
    """
    v, f = mesh_arrays(template) or template
    inside, pieces = _catamaran.locate_union(
        listed(parts), v, f, model, weld, threads, callback(progress)
    )
    warn_of_parts(pieces)
    return inside
