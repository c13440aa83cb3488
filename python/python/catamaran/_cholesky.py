"""Factorizations of sparse symmetric matrices."""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._options import Progress, callback, csr, is_sparse
from ._words import Triangle

__all__ = ["Cholesky", "cholesky"]


class Cholesky:
    """The factorization ``A = L @ L.T`` of a sparse symmetric matrix, as `cholesky` makes it.

    Several threads may use one: a call waits for those of other threads.
    """

    def __init__(self, handle: _catamaran.CholeskyHandle) -> None:
        self._handle = handle

    def solve(
        self, b: ArrayLike, *, rows: Optional[ArrayLike] = None, progress: Progress = None
    ) -> NDArray[np.float64]:
        """Solves ``A @ x = b``.

        Parameters
        ----------
        b : array_like, n or n x k
            The right-hand sides, in columns.
        rows : array_like of integers, optional
            Rows of x that are wanted, from 0 and in any order; all by default. Others take no
            memory.
        progress
            As in `ata`.

        Returns
        -------
        ndarray, of the shape of `b`, or with the wanted rows
        """
        if is_sparse(b):
            raise TypeError("b: expected an array, got a sparse matrix: b.toarray() is one")
        x = self._handle.solve(b, rows, callback(progress))
        return x[:, 0] if np.ndim(b) == 1 else x

    def refactor(self, a: Any, *, progress: Progress = None) -> None:
        """Factorizes another matrix with the same pattern, without another analysis.

        Parameters
        ----------
        a : sparse matrix, n x n
            A matrix without entries where the first one had none. After an exception there is no
            factorization until the next call succeeds.
        progress
            As in `ata`.
        """
        self._handle.factor(csr("a", a), callback(progress))

    @property
    def shape(self) -> Tuple[int, int]:
        """Rows and columns of A."""
        return (self._handle.n, self._handle.n)

    @property
    def entries(self) -> int:
        """Number of entries of L that are stored, zeros included."""
        return self._handle.entries

    @property
    def held(self) -> NDArray[np.int64]:
        """The rows that are held at zero, ascending; none of a definite matrix."""
        return self._handle.held

    @property
    def weakest(self) -> Optional[Tuple[int, float]]:
        """The row with the smallest pivot relative to its diagonal entry, and this ratio.

        At 1e-12, solutions may lose 12 digits. None without rows that are not held.
        """
        return self._handle.weakest

    def __repr__(self) -> str:
        n = self._handle.n
        return f"<Cholesky of a {n} x {n} matrix, {self.entries} entries, {len(self.held)} held>"


def cholesky(
    a: Any,
    *,
    triangle: Triangle = "both",
    semidefinite: bool = False,
    tolerance: Optional[float] = None,
    order: Optional[ArrayLike] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Cholesky:
    """Factorizes a sparse symmetric matrix, positive definite or semidefinite.

    Parameters
    ----------
    a : sparse matrix, n x n
        The matrix, of scipy.sparse in any format.
    triangle : {"both", "lower", "upper"}
        Which triangle is read. Both must agree; what is stored of the other one is ignored.
    semidefinite : bool
        Whether pivots may be zero up to rounding. The rows of such pivots are held: x is 0 there,
        and their equations follow from the others if there is a solution. A Laplacian has one in
        each component.
    tolerance : float, optional
        Largest pivot that is zero, relative to the diagonal entry of its row: 8 n 2^-52 for
        semidefinite matrices, 0 for others.
    order : array_like of n integers, optional
        The rows in the order of elimination, each once, as that of METIS. By default approximate
        minimum degree, from 100,000 rows on after nested dissection.
    threads, progress
        As in `ata`.

    Returns
    -------
    Cholesky
        ``solve``, ``refactor``.

    Raises
    ------
    ValueError
        Names the row at which elimination fails when the matrix is not definite.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> from scipy.sparse import csr_array
    >>> a = csr_array(np.array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> catamaran.cholesky(a).solve(np.array([1.0, 1.0])).round(12)
    array([1., 1.])

    The Laplacian of a mesh, with values at two vertices that sum to zero:

    >>> stiffness = catamaran.laplacian(*catamaran.shapes.icosphere(2)).stiffness
    >>> b = np.zeros(stiffness.shape[0])
    >>> b[0], b[1] = 1, -1
    >>> x = catamaran.cholesky(stiffness, semidefinite=True).solve(b)
    >>> bool(abs(stiffness @ x - b).max() < 1e-12)
    True
    """
    handle = _catamaran.CholeskyHandle(
        csr("a", a), triangle, semidefinite, tolerance, order, threads, callback(progress)
    )
    return Cholesky(handle)
