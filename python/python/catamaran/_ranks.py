"""Sums over the rows of all ranks of a communicator of mpi4py.

Only methods of the communicator are called, so that every wheel works with every MPI that mpi4py
was built for. Rows stay where they are; accumulators travel.
"""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterator, List, Optional

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._frames import refuse_other_rows
from ._options import is_sparse, matrix_of
from ._products import Accumulator, is_wide
from ._words import Sums

#: Rows of A and B that are joined at a time.
BLOCK = 4096


def gathered(comm: Any, work: Callable[[], Any]) -> List[Any]:
    """Returns what `work` returns on each rank. If it fails on one, every rank raises an error."""
    if not hasattr(comm, "allgather"):
        kind = type(comm).__name__
        raise TypeError(f"comm: expected a communicator, such as MPI.COMM_WORLD, got a {kind}")
    found, error, said = None, None, None
    try:
        found = work()
    # KeyboardInterrupt too: the other ranks would wait forever.
    except BaseException as caught:
        error, said = caught, f"{type(caught).__name__}: {caught}"
    everything = comm.allgather((found, said))
    if error is not None:
        raise error
    for rank, (_, why) in enumerate(everything):
        if why is not None:
            raise RuntimeError(f"rank {rank}: {why}")
    return [result for result, _ in everything]


def of_first(comm: Any, work: Callable[[], Any]) -> Any:
    """Returns on every rank what `work` returns on rank 0, or raises an error on every one."""
    return gathered(comm, lambda: work() if comm.rank == 0 else None)[0]


def sums(
    comm: Any,
    a: ArrayLike,
    b: Optional[ArrayLike],
    weights: Optional[ArrayLike],
    kind: Sums,
    center: bool,
    dtype: Optional[DTypeLike],
    more: Dict[str, Any],
) -> Any:
    """Returns an `Accumulator` over the rows ``[A B]`` of all ranks on rank 0, and None on the
    others. Exact and extended sums have the same bytes for any number of ranks and any distribution
    of the rows. `more` is for `Accumulator.add`."""
    parts: List[NDArray[Any]] = []
    masses: Optional[NDArray[np.float64]] = None

    def survey() -> Any:
        nonlocal masses
        refuse_other_rows(a, b=b, weights=weights)
        for name, given in (("a", a), ("b", b)):
            if given is not None:
                if is_sparse(given):
                    raise TypeError(f"{name}: sparse, where comm needs a dense matrix")
                part = matrix_of(name, given)
                part = part[:, None] if name == "b" and part.ndim == 1 else part
                if part.ndim != 2:
                    raise ValueError(f"{name}: expected an array of 2 dimensions, got {part.ndim}")
                if part.dtype.kind not in "fiub":
                    raise TypeError(f"{name}: {part.dtype} can't be summed over ranks")
                parts.append(part)
        is_wide(parts[0], dtype)
        rows = parts[0].shape[0]
        if parts[-1].shape[0] != rows:
            raise ValueError(f"b: {parts[-1].shape[0]} rows, where a has {rows}")
        single = kind != "extended" and parts[0].dtype == np.float32
        scalar = np.dtype(dtype or (np.float32 if single else np.float64)).name
        largest = None
        if weights is not None:
            masses = np.asarray(matrix_of("weights", weights), dtype=np.float64)
            if masses.shape != (rows,):
                raise ValueError(f"weights: shape {masses.shape}, where a has {rows} rows")
            if kind == "extended" and (masses < 0).any():
                row = int(np.argmax(masses < 0))
                raise ValueError(f"weights: weight {row} is negative: {masses[row]}")
            largest = float(np.abs(masses).max(initial=0.0))
        ends: List[NDArray[np.float64]] = []
        for name, part in zip("ab", parts if kind != "float" and rows else []):
            # Bounds of integers and truth values are numbers, too.
            ends.append(np.array([part.min(axis=0), part.max(axis=0)], dtype=np.float64))
            finite = np.isfinite(ends[-1]).all(axis=0)
            if not finite.all():
                column = int(np.argmin(finite))
                raise ValueError(f"{name}: column {column} has an entry that is not finite")
        common = {
            "columns": sum(part.shape[1] for part in parts),
            "type of sums": scalar,
            "kind of sums": kind,
            "centring": center,
            "presence of weights": weights is not None,
        }
        return common, rows, np.hstack(ends) if ends else None, largest

    found = gathered(comm, survey)
    for rank, (common, *_) in enumerate(found):
        for what, value in common.items():
            if value != found[0][0][what]:
                first = found[0][0][what]
                raise ValueError(f"rank {rank}: {what}: {value}, where rank 0 has {first}")
    common = found[0][0]

    def add() -> Accumulator:
        bounds = largest = None
        if kind != "float":
            ends = [rank[2] for rank in found if rank[2] is not None]
            ends = ends or [np.zeros((2, common["columns"]))]
            least = np.min([least for least, _ in ends], axis=0)
            most = np.max([most for _, most in ends], axis=0)
            bounds = (least, most, max(1, sum(rank[1] for rank in found)))
            largest = max(rank[3] for rank in found) if weights is not None else None
        total = Accumulator(
            common["columns"],
            center=center,
            dtype=common["type of sums"],
            kind=kind,
            bounds=bounds,
            largest_weight=largest,
        )
        for rows, of_rows in blocks(parts, masses):
            total.add(rows, of_rows, **more)
        return total

    own: List[Accumulator] = []
    gathered(comm, lambda: own.append(add()))
    return comm.reduce(own[0], op=joined, root=0)


def blocks(parts: List[NDArray[Any]], weights: Optional[NDArray[Any]]) -> Iterator[Any]:
    """Yields rows, of A and B side by side, and their weights."""
    if len(parts) == 1:
        yield parts[0], weights
        return
    for first in range(0, parts[0].shape[0], BLOCK):
        here = slice(first, first + BLOCK)
        yield (
            np.column_stack([part[here] for part in parts]),
            None if weights is None else weights[here],
        )


def joined(one: Accumulator, other: Accumulator) -> Accumulator:
    """Adds the sums of `other` to those of `one`."""
    one.merge(other)
    return one
