"""Orthonormal bases of columns."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, mass_of, rows_of
from ._words import Method

__all__ = ["Orthonormal", "orthogonality", "orthogonalize", "qr"]


class Orthonormal(NamedTuple):
    """A basis of `orthogonalize`: ``a[:, kept] = q @ r[:, kept]``."""

    #: m x rank, orthonormal columns.
    q: NDArray[np.float64]
    #: rank x n: coefficients of every column.
    r: NDArray[np.float64]
    #: The columns that `q` is made of.
    kept: NDArray[Any]


def qr(
    a: ArrayLike,
    *,
    mass: Any = None,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Factors a tall matrix of independent columns: ``a = q @ r``, by the Gram matrix.

    Parameters
    ----------
    a : array_like, m x n
        The matrix. Columns that depend on others are a ValueError that names them.
    mass : array_like of m numbers, or a matrix of scipy.sparse, optional
        The inner product M: ``q.T @ M @ q`` is the identity.
    threads, progress
        As in `ata`.

    Returns
    -------
    q : ndarray, m x n
        Orthonormal columns: up to rounding, for condition numbers up to 10^14 without `mass`.
    r : ndarray, n x n
        Upper triangular, with a positive diagonal.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> q, r = catamaran.qr(np.array([[3.0, 1.0], [4.0, 1.0]]))
    >>> q
    array([[ 0.6,  0.8],
           [ 0.8, -0.6]])
    """
    a = rows_of("a", a) if mass is None else a
    return _catamaran.qr(a, mass_of(mass), threads, callback(progress))


def orthogonalize(
    a: ArrayLike,
    *,
    mass: Any = None,
    method: Method = "reorthogonalized",
    threshold: Optional[float] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Orthonormal:
    """Makes an orthonormal basis of the columns of `a`, and leaves out those that depend on others.

    Parameters
    ----------
    a : array_like, m x n
        The columns.
    mass : array_like of m numbers, or a matrix of scipy.sparse, optional
        The inner product.
    method : {"reorthogonalized", "single_pass", "rank_revealing"}
        Gram-Schmidt until nothing changes any more, or once; or a basis of the numerical rank.
    threshold : float, optional
        A column is left out when less than this part of its norm is left: 1e-9, and 1e-2 for
        "single_pass".
    threads, progress
        As in `ata`.

    Returns
    -------
    Orthonormal

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> basis = catamaran.orthogonalize(np.array([[3.0, 6.0, 1.0], [4.0, 8.0, 1.0]]))
    >>> basis.kept
    array([0, 2], dtype=uint64)
    """
    found = _catamaran.orthogonalize(
        a, mass_of(mass), method, threshold, threads, callback(progress)
    )
    return Orthonormal(*found)


def orthogonality(
    q: ArrayLike, *, threads: Optional[int] = None, progress: Progress = None
) -> Tuple[float, float]:
    """Returns how far ``Q^T Q`` is from the identity, without rounding on the way.

    Parameters
    ----------
    q : array_like, m x n
        The columns.
    threads, progress
        As in `ata`.

    Returns
    -------
    frobenius, largest : float
        The Frobenius norm of ``Q^T Q - I``, and its largest entry by size.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> catamaran.orthogonality(np.eye(3)[:, :2] * (1 + 2**-52))[1] == 2**-51 + 2**-104
    True
    """
    return _catamaran.orthogonality(rows_of("q", q), threads, callback(progress))
