"""Options that several functions share."""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, Any, Callable, Optional, Tuple, TypeVar, Union, cast

from ._catamaran import Nearest

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: A callable that is told `done` and `total`, or a progress bar of tqdm.
Progress = Union[Callable[[int, int], Any], Any, None]

#: A word, or the factor that errors may grow by.
Accuracy = Union[str, float]

F = TypeVar("F", bound=Callable[..., Any])


def to_nearest(function: F) -> F:
    """Make a function compute in the default floating-point environment, whatever the caller's."""

    @wraps(function)
    def computed(*arguments: Any, **named: Any) -> Any:
        with Nearest():
            return function(*arguments, **named)

    return cast(F, computed)


def callback(progress: Progress) -> Optional[Callable[[int, int], Any]]:
    """Return a callable of `done` and `total` for a callable or a progress bar."""
    if progress is None:
        return None
    if hasattr(progress, "update") and hasattr(progress, "n"):
        bar: Any = progress

        def update(done: int, total: int) -> None:
            if bar.total is None:
                bar.total = total
            bar.update(done / total * bar.total - bar.n)

        return update
    if not callable(progress):
        raise TypeError("progress: expected a callable or a progress bar")
    return progress


def products(
    uplo: str, scheme: str, accuracy: Accuracy, reproducible: bool, threads: Optional[int]
) -> Tuple[str, str, Accuracy, bool, Optional[int]]:
    """Return the options of a product as the extension takes them."""
    return (uplo, scheme, accuracy, reproducible, threads)


def is_sparse(a: Any) -> bool:
    """Return whether `a` is a matrix of scipy.sparse, without importing it."""
    return hasattr(a, "tocsr") and hasattr(a, "nnz")


def csr(a: Any) -> Tuple[Any, Any, Any, Tuple[int, int]]:
    """Return a matrix of scipy.sparse as the extension takes it."""
    import numpy as np

    a = a.tocsr()
    if a.dtype.kind == "c":
        raise TypeError("a: complex, where sparse matrices must be real")
    if not a.has_canonical_format:
        a = a.copy()
        a.sum_duplicates()
    data = np.asarray(a.data, dtype=np.float64)
    return (data, a.indices.astype(np.uintp), a.indptr.astype(np.uintp), a.shape)


def to_scipy(parts: Tuple[Any, Any, Any, Tuple[int, int]]) -> Any:
    """Return a `scipy.sparse.csr_array` of what the extension returns."""
    # Not at the top: it takes as long to load as all else.
    from scipy.sparse import csr_array

    data, indices, indptr, shape = parts
    return csr_array((data, indices, indptr), shape=shape)


def mass_of(mass: Optional[ArrayLike]) -> Any:
    """Return a vector of masses or a sparse matrix as the extension takes it."""
    return csr(mass) if is_sparse(mass) else mass
