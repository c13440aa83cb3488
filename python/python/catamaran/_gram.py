"""Least squares, principal components and singular values from one A^T A."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, to_nearest

__all__ = ["SVD", "LeastSquares", "PrincipalComponents", "lstsq", "pca", "svd"]


def fit_options(
    ridge: float,
    intercept: bool,
    rank_deficiency: str,
    standard_errors: bool,
    threads: Optional[int],
) -> Dict[str, Any]:
    """Return options of least squares as the extension takes them."""
    return {
        "ridge": ridge,
        "intercept": intercept,
        "rank_deficiency": rank_deficiency,
        "standard_errors": standard_errors,
        "threads": threads,
    }


@dataclass(frozen=True)
class LeastSquares:
    """A solution of `lstsq`. With a vector `b` the attributes without a number of targets in their
    shape are numbers, and `x` is a vector."""

    #: The coefficients, n x k.
    x: NDArray[np.float64]
    #: What rounding took from the coefficients, n x k.
    x_low: NDArray[np.float64]
    #: The constant of each target; zeros unless it was asked for.
    intercept: Any
    #: ``|A x - b|`` for each target.
    residual_norm: Any
    #: ``1 - |A x - b|^2 / |b|^2``, about the mean with an intercept.
    r_squared: Any
    #: The standard error of each coefficient, n x k; empty when not asked for.
    standard_errors: NDArray[np.float64]
    #: The standard error of each intercept.
    intercept_errors: Any
    #: Columns of A that do not depend on others, as far as the precision can tell.
    rank: int
    #: The other columns.
    dependent: NDArray[np.uintp]
    #: Estimate of the condition number of A.
    condition: float
    #: Rows less the rank, and less one more with an intercept.
    degrees_of_freedom: int
    #: Decimal digits of the coefficients that agree with the exact solution, from 0 to 15.95.
    digits: float

    def predict(self, a: ArrayLike) -> NDArray[np.float64]:
        """Return ``A x + intercept``."""
        found: NDArray[np.float64] = np.asarray(a) @ self.x + self.intercept
        return found


def lstsq(
    a: ArrayLike,
    b: ArrayLike,
    *,
    weights: Optional[ArrayLike] = None,
    ridge: float = 0.0,
    intercept: bool = False,
    rank_deficiency: str = "minimum_norm",
    standard_errors: bool = True,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> LeastSquares:
    """Solve ``min |W^(1/2) (A X - B)|^2 + ridge |X|^2`` in one pass over the rows.

    The Gram matrix of ``[A B]`` is formed in extended precision (159 bits), so that the solution
    is at least as accurate as by an orthogonal factorization of A in float64.

    Parameters
    ----------
    a : array_like, m x n
        The matrix A. float32 and float64 are not copied.
    b : array_like of m numbers, or m x k
        The targets B.
    weights : array_like of m numbers, optional
        The diagonal of W, none of them negative.
    ridge : float
        What ``|X|^2`` is multiplied by; the intercept is not a part of X.
    intercept : bool
        Whether a constant is fitted too.
    rank_deficiency : {"minimum_norm", "refuse"}
        What happens when columns of A depend on others: of all solutions the one of least norm, or
        a ValueError that names the columns.
    standard_errors : bool
        Whether they are computed, which takes a few times as long as the solution.
    threads, progress
        As in `ata`.

    Returns
    -------
    LeastSquares

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> t = np.arange(5.0)
    >>> found = catamaran.lstsq(t[:, None], 2 * t + 1, intercept=True)
    >>> float(found.x[0]), float(found.intercept), found.rank
    (2.0, 1.0, 1)
    """
    options = fit_options(ridge, intercept, rank_deficiency, standard_errors, threads)
    found = _catamaran.lstsq(a, b, weights, options, callback(progress))
    if np.ndim(b) == 1:
        for name in ("x", "x_low", "standard_errors"):
            found[name] = found[name][:, 0] if found[name].size else found[name].ravel()
        for name in ("intercept", "residual_norm", "r_squared", "intercept_errors"):
            found[name] = found[name][0] if found[name].size else found[name]
    return LeastSquares(**found)


class PrincipalComponents:
    """Principal components of `pca`.

    Attributes
    ----------
    components : ndarray, count x n
        One orthonormal row for each component, the most variance first.
    explained_variance, explained_variance_ratio : ndarray of count numbers
        The variance along each component, and its share of all variance.
    singular_values : ndarray of count numbers
        Of the centred (and standardized) rows.
    mean, scale : ndarray of n numbers
        What is subtracted from each column, and what it is then divided by.
    whiten : bool
        Whether scores have variance 1.
    """

    def __init__(self, found: _catamaran.PrincipalComponents) -> None:
        self._found = found
        self.components: NDArray[np.float64] = found.components
        self.explained_variance: NDArray[np.float64] = found.explained_variance
        self.explained_variance_ratio: NDArray[np.float64] = found.explained_variance_ratio
        self.singular_values: NDArray[np.float64] = found.singular_values
        self.mean: NDArray[np.float64] = found.mean
        self.scale: NDArray[np.float64] = found.scale
        self.whiten: bool = found.whiten

    def transform(self, rows: ArrayLike, *, progress: Progress = None) -> NDArray[np.float64]:
        """Return the scores (m x count) of rows (m x n)."""
        return self._found.transform(rows, callback(progress))

    def __repr__(self) -> str:
        count, n = self.components.shape
        share = float(self.explained_variance_ratio.sum())
        return f"PrincipalComponents({count} of {n} columns, {share:.1%} of the variance)"


def pca(
    a: ArrayLike,
    n_components: Union[int, float, None] = None,
    *,
    weights: Optional[ArrayLike] = None,
    standardize: bool = False,
    whiten: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> PrincipalComponents:
    """Compute the principal components of the rows of `a`, in one pass over them.

    Parameters
    ----------
    a : array_like, m x n
        A row for each observation.
    n_components : int or float, optional
        How many components, or the share of the variance that they explain; all by default.
    weights : array_like of m numbers, optional
        How often each row counts.
    standardize : bool
        Whether columns are divided by their standard deviation.
    whiten : bool
        Whether scores are divided by the root of the variance that they explain.
    threads, progress
        As in `ata`.

    Returns
    -------
    PrincipalComponents

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> found = catamaran.pca(np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]))
    >>> found
    PrincipalComponents(1 of 2 columns, 100.0% of the variance)
    >>> found.mean
    array([2., 4.])
    """
    found = _catamaran.pca(
        a, weights, n_components, standardize, whiten, threads, callback(progress)
    )
    return PrincipalComponents(found)


class SVD(NamedTuple):
    """Singular values and vectors of `svd`."""

    #: m x rank, or None when not asked for.
    u: Optional[NDArray[np.float64]]
    #: n values, descending; zeros where columns depend on others.
    s: NDArray[np.float64]
    #: rank x n: right singular vectors.
    vh: NDArray[np.float64]


@to_nearest
def svd(
    a: ArrayLike,
    *,
    compute_u: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> SVD:
    """Compute the singular values and vectors of a tall matrix in one pass over its rows.

    Small singular values have as many digits as large ones, as long as the condition number of A
    with columns of norm 1 is below 2^48 or so.

    Parameters
    ----------
    a : array_like, m x n
        The matrix.
    compute_u : bool
        Whether left singular vectors are computed in a second pass, ``A V / s``. They are
        orthogonal up to about 2^-53 times the largest value over the value of each.
    threads, progress
        As in `ata`.

    Returns
    -------
    SVD
        ``u`` (None without `compute_u`), ``s``, ``vh``.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> catamaran.svd(np.array([[3.0, 0.0], [0.0, 1e-9], [0.0, 0.0]])).s
    array([3.e+00, 1.e-09])
    """
    s, v = _catamaran.svd(a, threads, callback(progress))
    u = None
    if compute_u:
        u = np.asarray(a) @ v
        u /= s[: v.shape[1]]
    return SVD(u, s, v.T)
