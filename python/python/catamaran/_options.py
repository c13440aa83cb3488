"""Options that several functions share."""

from __future__ import annotations

import os
import sys
import warnings
from functools import wraps
from typing import (
    TYPE_CHECKING,
    Any,
    Callable,
    List,
    NamedTuple,
    Optional,
    Tuple,
    TypeVar,
    Union,
    cast,
)

from ._catamaran import Nearest

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._words import Accuracy, Scheme, Triangle

Path = Union[str, "os.PathLike[str]"]

#: A callable that is told `done` and `total`, or a progress bar of tqdm.
Progress = Union[Callable[[int, int], Any], Any, None]

F = TypeVar("F", bound=Callable[..., Any])


def to_nearest(function: F) -> F:
    """Makes a function compute in the default floating-point environment, whatever the caller's."""

    @wraps(function)
    def computed(*arguments: Any, **named: Any) -> Any:
        with Nearest():
            return function(*arguments, **named)

    return cast(F, computed)


def callback(progress: Progress) -> Optional[Callable[[int, int], Any]]:
    """Returns a callable of `done` and `total` for a callable or a progress bar."""
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


def part(progress: Progress, start: float, stop: float) -> Optional[Callable[[int, int], Any]]:
    """Returns a callable for the part of the progress from `start` to `stop`, as parts of 1."""
    whole = callback(progress)
    if whole is None:
        return None
    call: Callable[[int, int], Any] = whole

    def update(done: int, total: int) -> None:
        call(round((start + (stop - start) * done / total) * total), total)

    return update


def products(
    uplo: Triangle,
    scheme: Scheme,
    accuracy: Accuracy,
    reproducible: bool,
    threads: Optional[int],
    backend: Optional[Path],
) -> Tuple[str, str, Accuracy, bool, Optional[int], Optional[str]]:
    """Returns the options of a product as the extension takes them."""
    library = None if backend is None else os.fspath(backend)
    return (uplo, scheme, accuracy, reproducible, threads, library)


def is_sparse(a: Any) -> bool:
    """Returns whether `a` is a matrix of scipy.sparse, without importing it."""
    return hasattr(a, "tocsr") and hasattr(a, "nnz")


class Csr(NamedTuple):
    """A sparse matrix by rows, as the extension takes it."""

    data: Any
    indices: Any
    indptr: Any
    shape: Tuple[int, int]


def csr(name: str, a: Any) -> Csr:
    """Returns a matrix of scipy.sparse as the extension takes it; anything else is refused.

    `name` is that of the argument, in errors.
    """
    import numpy as np

    if not is_sparse(a):
        raise TypeError(f"{name}: expected a matrix of scipy.sparse, got {type(a).__name__}")
    a = a.tocsr()
    if a.dtype.kind == "c":
        raise TypeError(f"{name}: complex, where sparse matrices must be real")
    if not a.has_canonical_format:
        a = a.copy()
        a.sum_duplicates()
    data = np.asarray(a.data, dtype=np.float64)
    return Csr(data, a.indices.astype(np.uintp), a.indptr.astype(np.uintp), a.shape)


def rows_of(name: str, a: Any) -> Any:
    """Returns a matrix, which may be one of scipy.sparse, as the extension takes its rows.

    `name` is that of the argument, in errors.
    """
    return csr(name, a) if is_sparse(a) else a


def matrix_of(name: str, a: Any) -> Any:
    """Returns a matrix of scipy.sparse as it is, anything else as an array without a mask; missing
    entries of a data frame are NaN."""
    import numpy as np

    from ._frames import frame_of

    if is_sparse(a):
        return a
    if np.ma.is_masked(a):
        count = np.ma.getmaskarray(a).sum()
        raise ValueError(f"{name}: {count} entries are masked: fill them, or leave out their rows")
    frame = frame_of(name, a)
    return np.asarray(a) if frame is None else frame.rows(0, frame.shape[0])


def some(numbers: Any) -> Any:
    """Returns one number as a list of it, anything else as it is."""
    import numpy as np

    return [numbers] if isinstance(numbers, (int, np.integer)) else numbers


def to_scipy(parts: Tuple[Any, Any, Any, Tuple[int, int]]) -> Any:
    """Returns a `scipy.sparse.csr_array` of what the extension returns."""
    # Not at the top: it takes as long to load as all else.
    from scipy.sparse import csr_array

    data, indices, indptr, shape = parts
    return csr_array((data, indices, indptr), shape=shape)


def mass_of(mass: Optional[ArrayLike]) -> Any:
    """Returns a vector of masses or a sparse matrix as the extension takes it."""
    return csr("mass", mass) if is_sparse(mass) else mass


def warn_caller(message: str) -> None:
    """Issues a warning at the line outside of this package that called it."""
    level, frame = 1, sys._getframe()
    while frame.f_back and frame.f_globals.get("__package__") == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, UserWarning, stacklevel=level)


def warn_of_pieces(
    pieces: Tuple[int, int, int, int, int],
    *,
    dirichlet: bool,
    shifted: bool,
    name: str,
) -> None:
    """Warns of a mesh with several components, of vertices in no face, and of repeated faces.

    `pieces` are the components, those without a vertex held at zero, those that are left with
    `weld`, the vertices in no face, and the faces that repeat another. With `dirichlet` a mesh
    without a boundary is named, too; with `shifted` the eigenvalues may lie far from zero, and
    components are not. `name` is that of the mesh, if there are several.
    """
    count, free, left, alone, repeated = pieces
    found: List[str] = []
    zeros = "1 eigenvalue is zero" if free == 1 else f"{free} eigenvalues are zero"
    if count > 1 and not shifted:
        what = f"the mesh has {count} components"
        if free == 0:
            what += ", whose eigenvalues are in one list"
        else:
            what += f": {zeros}, one for each"
            what += "" if free == count else " without a vertex held at zero"
        found.append(what + (f"; weld=True joins them into {left}" if left < count else ""))
    elif free > 0 and dirichlet and not shifted:
        found.append("the mesh has no boundary")
    if alone > 0:
        found.append(f"vertices in no face: {alone}; eigenfunctions are zero there")
    if repeated > 0:
        found.append(f"faces that repeat another, and add to it: {repeated}; repair leaves them out")
    for message in found:
        warn_caller(f"{name}: {message}" if name else message)
