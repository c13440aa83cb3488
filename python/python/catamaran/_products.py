"""A^T A and A^T B, covariances, plans, and sums of rows that come in blocks."""

from __future__ import annotations

import os
from typing import Any, Literal, NamedTuple, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _catamaran
from ._frames import refuse_other_rows
from ._gram import LeastSquares, PrincipalComponents, fit_options, solution
from ._options import (
    Path,
    Progress,
    callback,
    csr,
    is_sparse,
    matrix_of,
    products,
    rows_of,
    to_nearest,
    warn_caller,
)
from ._words import Accuracy, RankDeficiency, Scheme, Sums, Triangle

__all__ = ["Accumulator", "Verification", "ata", "corrcoef", "cov", "plan", "verify"]


def _center(center: Any) -> Any:
    """Returns None, True for the mean, or a row."""
    if center is None or center is False:
        return None
    if center is True or isinstance(center, str):
        if center not in (True, "mean"):
            raise ValueError(f"center: '{center}' is not one of True, 'mean', an array")
        return True
    return center


def is_wide(a: Any, dtype: Optional[DTypeLike]) -> bool:
    """Returns whether `dtype` asks for a result of float64; refuses another than that of `a`."""
    if dtype is None:
        return False
    wide = bool(np.dtype(dtype) == np.float64)
    if not wide and np.dtype(dtype) != np.asarray(a).dtype:
        raise TypeError("dtype: expected numpy.float64, or that of a")
    return wide


def ata(
    a: ArrayLike,
    b: Optional[ArrayLike] = None,
    *,
    weights: Optional[ArrayLike] = None,
    center: Union[bool, Literal["mean"], ArrayLike, None] = None,
    out: Optional[NDArray[Any]] = None,
    alpha: float = 1.0,
    beta: float = 0.0,
    uplo: Triangle = "both",
    scheme: Scheme = "auto",
    accuracy: Accuracy = "default",
    reproducible: bool = False,
    dtype: Optional[DTypeLike] = None,
    backend: Optional[Path] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
    comm: Any = None,
) -> NDArray[Any]:
    """Computes ``alpha A^T A + beta C``, or ``alpha A^T B + beta C``.

    Complex matrices are conjugated: ``A^H A`` and ``A^H B``. For ``A A^T`` pass ``a.T``, which
    costs nothing: arrays may have any strides, and no copy is made of float32, float64, complex64
    and complex128. Other real numbers become float64.

    Parameters
    ----------
    a : array_like, m x n or count x m x n, or a matrix of scipy.sparse
        The matrix A, or a stack of real matrices, whose products are a stack, count x n x n;
        without `b`, `weights`, `center`, `out` and `comm`. Threads share the products.
    b : array_like, m x k, optional
        The matrix B.
    weights : array_like of m numbers, optional
        ``A^T diag(weights) A``; real matrices only.
    center : True, "mean" or array_like of n numbers, optional
        What is subtracted from every row first: the mean, weighted if there are weights, or this
        row; real matrices only.
    out : ndarray, n x n (n x k with B), optional
        Where the result goes: C. Any strides; its dtype is that of the result. It has no element in
        common with A and B, but may be in the same buffer.
    alpha, beta : float
        Factors. With ``beta == 0``, the default, the content of `out` is not read.
    uplo : {"both", "lower", "upper"}
        The part of ``A^T A`` that is computed. The strict other triangle of `out` is neither read
        nor written; that of a new array is zero.
    scheme : {"auto", "float", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3", "exact"}
        Which recursion runs; `plan` says what "auto" chooses.
    accuracy : {"default", "max", "classical", "fast"} or float
        What fast products may cost in accuracy; a number is the factor that errors may grow by.
    reproducible : bool
        The same bytes on every machine.
    dtype : dtype, optional
        ``numpy.float64`` computes a float64 result of float32 rows, without a copy of A.
    backend : path, optional
        A shared library with the CBLAS interface and 32-bit integers (MKL, OpenBLAS, BLIS) that
        computes the small products instead of the kernels of this package. Its initializers run:
        load only what you trust. A library that can't be loaded is a RuntimeError.
    threads : int, optional
        Threads, at most; by default one for each core, at most ``RAYON_NUM_THREADS`` and
        ``CATAMARAN_NUM_THREADS`` (or, where that is not set, ``OMP_NUM_THREADS``). The result does
        not depend on it, bit for bit.
    progress : callable or tqdm bar, optional
        ``progress(done, total)`` is called now and then; an exception in it ends the call.
    comm : communicator of mpi4py, optional
        Every rank of it has some rows of a real and dense `a`, and their weights, and gets the sum
        over all ranks; all of them make the call. Without `b`, `out`, `beta` and a row as `center`.
        With `reproducible` the bytes are the same for any number of ranks and any distribution of
        the rows. Each rank holds one triangle of sums beside its rows, and one more while they
        merge.

    Returns
    -------
    ndarray
        `out`, or a new array in C order.

    Raises
    ------
    ValueError, TypeError, MemoryError
        For arguments that do not fit, and a result that there is no memory for.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> a = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    >>> catamaran.ata(a)
    array([[35., 44.],
           [44., 56.]])
    >>> catamaran.ata(a, a[:, :1])
    array([[35.],
           [44.]])
    >>> catamaran.ata(a, center=True, alpha=1 / 2)  # the covariance
    array([[4., 4.],
           [4., 4.]])
    >>> catamaran.ata(a.T[::-1], uplo="lower")  # A A^T, in any order
    array([[ 5.,  0.,  0.],
           [11., 25.,  0.],
           [17., 39., 61.]])
    >>> catamaran.ata(np.array([[[1.0], [2.0]], [[3.0], [4.0]]])).ravel()  # two matrices
    array([ 5., 25.])
    """
    center = _center(center)
    if comm is not None:
        from ._ranks import of_first, sums

        if b is not None or out is not None or beta != 0 or not (center is None or center is True):
            raise ValueError("comm: not together with b, out, beta, or a row as center")
        if backend is not None:
            raise ValueError("comm: not together with backend")
        if reproducible and scheme not in ("auto", "exact"):
            raise ValueError("scheme: only the exact scheme is reproducible on every machine")
        exact = reproducible or scheme == "exact"
        way = "auto" if exact else scheme
        more = {"scheme": way, "accuracy": accuracy, "threads": threads, "progress": progress}
        kind: Sums = "exact" if exact else "float"
        total = sums(comm, a, None, weights, kind, center is True, dtype, more)
        c: NDArray[Any] = of_first(comm, lambda: total.result(alpha=alpha, uplo=uplo))
        return c
    refuse_other_rows(a, b=b, weights=weights)
    options = products(uplo, scheme, accuracy, reproducible, threads, backend)
    if progress is not None:
        progress = callback(progress)
    if is_sparse(a):
        if b is not None:
            raise TypeError("a: sparse, where b needs a dense matrix")
        rows = csr("a", a)
        return _catamaran.ata_sparse(rows, weights, center, out, alpha, beta, options, progress)
    wide = is_wide(a, dtype)
    return _catamaran.ata(a, b, weights, center, out, alpha, beta, options, wide, progress)


class Verification(NamedTuple):
    """What `verify` finds; it is true if the check passed."""

    #: Whether `residual` is at most `tolerance`.
    passed: bool
    #: The largest entry of ``(C - alpha A^T A) x`` over all random vectors x.
    residual: float
    #: The residual that rounding may cause.
    tolerance: float
    #: The probability that a C with an entry wrong by more than twice the tolerance passes.
    false_accept_probability: float

    def __bool__(self) -> bool:
        return self.passed


def verify(
    a: ArrayLike,
    c: ArrayLike,
    *,
    weights: Optional[ArrayLike] = None,
    center: Union[bool, Literal["mean"], ArrayLike, None] = None,
    alpha: float = 1.0,
    uplo: Triangle = "both",
    rounds: int = 20,
    seed: int = 0,
) -> Verification:
    """Checks a product ``C = alpha A^T A`` of `ata` with random vectors (Freivalds 1977).

    It takes O(rounds (m n + n^2)) operations, where the product takes O(m n^2).

    Parameters
    ----------
    a : array_like, m x n, or a matrix of scipy.sparse
        The real matrix A.
    c : array_like, n x n
        The product; of float32 with the tolerance of that precision.
    weights, center, alpha, uplo
        As in `ata`, which computed C.
    rounds : int
        Random vectors, from 1 to 1000: the probability that an error escapes is 2^-rounds.
    seed : int
        Of the vectors.

    Returns
    -------
    Verification
        ``passed``, ``residual``, ``tolerance``, ``false_accept_probability``.

    Raises
    ------
    ValueError
        Names an argument that does not fit, or an entry of A that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> a = np.arange(12.0).reshape(4, 3)
    >>> c = catamaran.ata(a)
    >>> bool(catamaran.verify(a, c)), bool(catamaran.verify(a, c + np.eye(3)))
    (True, False)
    """
    refuse_other_rows(a, weights=weights)
    middle = _center(center)
    return Verification(
        *_catamaran.verify(rows_of("a", a), c, weights, middle, alpha, uplo, rounds, seed)
    )


@to_nearest
def cov(
    a: ArrayLike,
    *,
    ddof: int = 1,
    fweights: Optional[ArrayLike] = None,
    aweights: Optional[ArrayLike] = None,
    rowvar: bool = False,
    reproducible: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> NDArray[Any]:
    """Computes the covariance matrix of the columns of `a`.

    As `numpy.cov`, except that variables are columns: ``rowvar=True`` says that they are rows.

    Parameters
    ----------
    a : array_like, m x n, or a matrix of scipy.sparse
        A row for each observation, a column for each variable.
    ddof : int
        What is subtracted from the number of observations in the divisor.
    fweights, aweights : array_like of m numbers, optional
        How often each observation counts, and its importance, as in `numpy.cov`.
    rowvar : bool
        Whether variables are rows.
    reproducible, threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, n x n

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> x = np.array([[0.0, 2.0], [1.0, 1.0], [2.0, 0.0]])
    >>> catamaran.cov(x)
    array([[ 1., -1.],
           [-1.,  1.]])
    """
    rows: Any = matrix_of("a", a)
    if rows.ndim == 2 and rowvar:
        rows = rows.T
    else:
        refuse_other_rows(a, fweights=fweights, aweights=aweights)
    if rows.ndim != 2:
        raise ValueError(f"a: expected an array of 2 dimensions, got {rows.ndim}")
    weights = None
    for name, more in (("fweights", fweights), ("aweights", aweights)):
        if more is not None:
            own: Any = matrix_of(name, more).astype(np.float64)
            if own.shape != rows.shape[:1]:
                raise ValueError(f"{name}: expected shape {rows.shape[:1]}, got {own.shape}")
            if not np.isfinite(own).all():
                row = int(np.argmin(np.isfinite(own)))
                raise ValueError(f"{name}: not finite at row {row}")
            weights = own if weights is None else weights * own
    total = rows.shape[0] if weights is None else float(weights.sum())
    lost = float(ddof)
    if aweights is not None and ddof and weights is not None:
        lost = ddof * float((weights * np.asarray(aweights, dtype=np.float64)).sum()) / total
    if total - lost <= 0.0:
        raise ValueError(
            f"ddof: {ddof} leaves no degree of freedom of {rows.shape[0]} observations"
        )
    return ata(
        rows,
        weights=weights,
        center=True,
        alpha=1.0 / (total - lost),
        reproducible=reproducible,
        threads=threads,
        progress=progress,
    )


def corrcoef(
    a: ArrayLike, *, rowvar: bool = False, threads: Optional[int] = None, progress: Progress = None
) -> NDArray[np.float64]:
    """Computes the correlation matrix of the columns of `a`, in extended precision.

    Entries are wrong by little more than one rounding, also where columns are far from zero beside
    their deviations. A column without variance has NaN.

    Parameters
    ----------
    a : array_like, m x n, or a matrix of scipy.sparse
        A row for each observation, a column for each variable.
    rowvar : bool
        Whether variables are rows, as `numpy.corrcoef` has it by default.
    threads, progress
        As in `ata`.

    Returns
    -------
    ndarray, n x n

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> x = np.array([[0.0, 2.0], [1.0, 1.0], [2.0, 0.0]]) + 1e8
    >>> catamaran.corrcoef(x)
    array([[ 1., -1.],
           [-1.,  1.]])
    """
    rows: Any = matrix_of("a", a).T if rowvar else a
    return _catamaran.corrcoef(rows_of("a", rows), threads, callback(progress))


def plan(
    m: int,
    n: int,
    k: Optional[int] = None,
    *,
    dtype: DTypeLike = np.float64,
    uplo: Triangle = "both",
    scheme: Scheme = "auto",
    accuracy: Accuracy = "default",
    reproducible: bool = False,
    backend: Optional[Path] = None,
    threads: Optional[int] = None,
) -> _catamaran.Plan:
    """Returns what `ata` will do for an m x n matrix, and why.

    Parameters
    ----------
    m, n : int
        Rows and columns of A.
    k : int, optional
        Columns of B.
    dtype : {float64, float32}
        The numbers.
    uplo, scheme, accuracy, reproducible, backend, threads
        As in `ata`.

    Returns
    -------
    Plan
        Its ``repr`` explains; ``is_exact``, ``is_fast``, ``scheme`` and ``isa`` are attributes.

    Examples
    --------
    >>> import catamaran
    >>> explained = catamaran.plan(100_000, 500, scheme="classical")
    >>> print(str(explained).splitlines()[0][:30])
    C = A^T A, A 100000 x 500, f64
    >>> explained.is_fast, explained.scheme
    (False, 'classical')
    """
    options = products(uplo, scheme, accuracy, reproducible, threads, backend)
    return _catamaran.plan(m, n, k, np.dtype(dtype).name, options)


class Accumulator(_catamaran.Accumulator):
    """Sums over rows that come in blocks: ``A^T W A`` of rows that were never all in memory.

    Parameters
    ----------
    columns : int
        Columns of the rows.
    center : bool
        Whether the result is about the mean of the rows.
    dtype : {float64, float32}
        Of the sums. Rows of float32 may be added to sums of float64.
    kind : {"float", "exact", "extended"}
        With "exact" the sums are integers: the result does not depend on the blocks and their
        order, and rows can be removed. With "extended" they are wide enough for `lstsq`, `pca`.
    bounds : (lower, upper, rows), optional
        For "exact" and "extended": the least and the largest entry of each column, and how many
        rows will come at most.
    largest_weight : float, optional
        For "exact" and "extended", if rows come with weights: the largest absolute value of one.

    Attributes
    ----------
    columns, rows : int
        Columns, and rows so far.
    weight : float
        Sum of the weights; the number of rows without.
    mean : ndarray
        The mean of the rows so far; empty without `center`.
    centered, exact, is_extended : bool
        What kind of sums they are.
    dtype : str
        Of the sums.

    Notes
    -----
    Accumulators can be pickled, for other processes, and copied by `copy.copy`. If `add` or
    `remove` fails after some blocks of the call were added, the accumulator must not be used any
    more: every later call raises an error that says so.

    Several threads may use one accumulator: a call waits for those of other threads, and Ctrl-C
    ends the wait. A progress callback can't use the accumulator of its own call.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> a = np.arange(12.0).reshape(6, 2)
    >>> sums = catamaran.Accumulator(2)
    >>> for block in (a[:2], a[2:]):
    ...     sums.add(block)
    >>> sums.rows
    6
    >>> bool(np.all(sums.result() == a.T @ a))
    True

    Integers forget rows without a trace:

    >>> exact = catamaran.Accumulator(2, kind="exact", bounds=([0, 0], [11, 11], 6))
    >>> exact.add(a)
    >>> exact.remove(a[3:])
    >>> bool(np.all(exact.result() == a[:3].T @ a[:3]))
    True
    """

    def __new__(
        cls,
        columns: int,
        *,
        center: bool = False,
        dtype: DTypeLike = np.float64,
        kind: Sums = "float",
        bounds: Optional[Tuple[ArrayLike, ArrayLike, int]] = None,
        largest_weight: Optional[float] = None,
    ) -> Accumulator:
        declared = None
        if bounds is not None:
            lower, upper, rows = bounds
            declared = (lower, upper, rows, largest_weight)
        elif largest_weight is not None:
            raise ValueError("largest_weight: applies to sums with bounds")
        scalar = np.dtype(dtype).name
        return super().__new__(cls, columns, center, scalar, kind, declared)

    def add(
        self,
        rows: ArrayLike,
        weights: Optional[ArrayLike] = None,
        *,
        scheme: Scheme = "auto",
        accuracy: Accuracy = "default",
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> None:
        """Adds rows (any number x columns), with a weight for each or none."""
        refuse_other_rows(rows, weights=weights)
        options = products("both", scheme, accuracy, False, threads, None)
        self._add(rows, weights, options, callback(progress))

    def add_file(
        self,
        path: Path,
        weights: Optional[ArrayLike] = None,
        *,
        scheme: Scheme = "auto",
        accuracy: Accuracy = "default",
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> None:
        """Adds the rows of a .npy file, or of a dataset of HDF5 ("a.h5:/x") in a package with that
        feature, with a weight for each or none. Blocks of rows are in memory, never the whole
        file; notes about the file are warnings."""
        options = products("both", scheme, accuracy, False, threads, None)
        for note in self._add_file(path, weights, options, callback(progress)):
            warn_caller(f"{os.fspath(path)}: {note}")

    def remove(
        self,
        rows: ArrayLike,
        weights: Optional[ArrayLike] = None,
        *,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> None:
        """Removes rows that were added to exact sums, with the same weights."""
        refuse_other_rows(rows, weights=weights)
        options = products("both", "auto", "default", False, threads, None)
        self._remove(rows, weights, options, callback(progress))

    def merge(self, other: Accumulator) -> None:
        """Adds the rows of another accumulator, which stays as it is. An error changes neither."""
        self._merge(other)

    def result(self, *, alpha: float = 1.0, uplo: Triangle = "both") -> NDArray[Any]:
        """Returns ``alpha A^T W A``, about the mean with `center`; more rows may come after it."""
        return self._result(alpha, uplo)

    def cov(self, *, ddof: int = 1) -> NDArray[Any]:
        """Returns the covariance matrix; needs `center`."""
        return self._cov(ddof)

    def extended(
        self, *, threads: Optional[int] = None
    ) -> Tuple[Tuple[NDArray[np.float64], ...], bool]:
        """Returns C of extended sums as three lower triangles that add up to it, about 159 bits,
        and whether no entry of the rows was rounded."""
        parts, exact = self._extended(threads)
        return tuple(parts), exact

    def lstsq(
        self,
        targets: int = 1,
        *,
        ridge: float = 0.0,
        intercept: bool = False,
        rank_deficiency: RankDeficiency = "minimum_norm",
        standard_errors: bool = True,
        threads: Optional[int] = None,
    ) -> LeastSquares:
        """Solves for the last `targets` columns of extended sums; see `catamaran.lstsq`."""
        options = fit_options(ridge, intercept, rank_deficiency, standard_errors, threads)
        return solution(self._lstsq(targets, options), False)

    def pca(
        self,
        n_components: Union[int, float, None] = None,
        *,
        standardize: bool = False,
        whiten: bool = False,
        threads: Optional[int] = None,
    ) -> PrincipalComponents:
        """Computes the principal components of float64 sums about the mean; see `catamaran.pca`.

        Unless the sums are extended, components whose singular values are below about 1e-7 of the
        largest are left out: they are rounding.
        """
        return PrincipalComponents(**self._pca(n_components, standardize, whiten, threads))

    def save(self, path: Path) -> None:
        """Writes the sums to a file, which appears whole or not at all and replaces an older one.
        ``catamaran ata-merge`` reads it, too."""
        self._save(path)

    @classmethod
    def load(cls, path: Path) -> Accumulator:
        """Reads the sums of `save`, or of ``catamaran ata --accumulator``."""
        sums = cls(1)
        sums._load(path)
        return sums

    def __copy__(self) -> Accumulator:
        return _restored(self._to_bytes())

    def __reduce__(self) -> Tuple[Any, ...]:
        return (_restored, (self._to_bytes(),))

    def __repr__(self) -> str:
        kind = "extended" if self.is_extended else "exact" if self.exact else "float"
        about = ", centered" if self.centered else ""
        return f"Accumulator({self.rows} rows of {self.columns}, {self.dtype}, {kind}{about})"


def _restored(data: bytes) -> Accumulator:
    sums = Accumulator(1)
    sums._restore(data)
    return sums
