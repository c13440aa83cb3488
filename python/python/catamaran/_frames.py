"""Data frames of pandas, polars and pyarrow, whose rows become arrays block by block."""

from __future__ import annotations

from typing import Any, Callable, List, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

#: What the type of a column of numbers begins with, in polars and in pyarrow.
NUMBERS = ("bool", "int", "uint", "float", "double", "halffloat", "decimal")

#: Types of single precision, or less.
SINGLE = ("float", "float32", "halffloat", "float16")


class Frame(NamedTuple):
    """A frame of columns of numbers."""

    #: Rows and columns.
    shape: Tuple[int, int]
    #: Whether all columns are in single precision.
    is_single: bool
    #: The rows from the first number on, as many as the second one says; NaN for missing entries.
    rows: Callable[[int, int], NDArray[Any]]


def frame_of(name: str, a: Any) -> Optional[Frame]:
    """Returns a frame; None for what is none, and for one that `numpy.asarray` does not copy.

    `name` is that of the argument, in errors.
    """
    if hasattr(a, "iloc"):
        return of_pandas(name, a) if getattr(a, "ndim", 0) == 2 else None
    if hasattr(a, "__arrow_c_stream__") and not hasattr(a, "slice"):
        import pyarrow

        a = pyarrow.table(a)
    if hasattr(a, "get_columns") and hasattr(a, "schema"):
        types, names = [str(kind).lower() for kind in a.dtypes], a.columns
    elif hasattr(a, "column_names") and hasattr(a, "schema"):
        types, names = [str(kind) for kind in a.schema.types], a.column_names
    else:
        return None
    refuse(name, [pair for pair in zip(names, types) if not pair[1].startswith(NUMBERS)])

    def rows(first: int, count: int) -> NDArray[Any]:
        block = a.slice(first, count)
        columns = block.get_columns() if hasattr(block, "get_columns") else block.columns
        return np.column_stack([numbers(column) for column in columns])

    return Frame(a.shape, all(kind in SINGLE for kind in types), rows) if types else None


def names_of(a: Any) -> Tuple[str, ...]:
    """Returns the names of the columns of a frame; none of anything else."""
    names = getattr(a, "column_names", None)
    if names is None and (hasattr(a, "iloc") or hasattr(a, "get_columns")):
        names = getattr(a, "columns", None)
    return () if names is None else tuple(str(name) for name in names)


def columns_of(name: str, a: Any, wanted: Tuple[str, ...]) -> Any:
    """Returns a frame of the columns with these names, in this order; anything else as it is.

    Raises
    ------
    ValueError
        Names the first column that the frame does not have, or has twice.
    """
    names = names_of(a)
    if not names or names == wanted:
        return a
    for column in wanted:
        if names.count(column) != 1:
            what = "has no column" if column not in names else "has two columns"
            raise ValueError(f"{name}: {what} {column}; the fit has {', '.join(wanted[:20])}")
    places = [names.index(column) for column in wanted]
    if hasattr(a, "iloc"):
        return a.iloc[:, places]
    return a.select([a.columns[k] for k in places] if hasattr(a, "get_columns") else places)


def refuse_other_rows(a: Any, **others: Any) -> None:
    """Refuses pandas arguments that have as many rows as the frame `a`, but another index.

    Raises
    ------
    ValueError
        Names the argument: rows of different labels would be taken as one observation.
    """
    if not hasattr(a, "iloc"):
        return
    for name, other in others.items():
        if not hasattr(other, "iloc") or len(other) != len(a) or other.index.equals(a.index):
            continue
        why = "reindex it, or to_numpy() takes its rows as they come"
        raise ValueError(f"{name}: its index is not that of the rows: {why}")


def of_pandas(name: str, a: Any) -> Optional[Frame]:
    """Returns a frame of pandas."""
    types = list(a.dtypes)
    if any(kind.kind == "c" for kind in types):
        return None
    refuse(name, [pair for pair in zip(a.columns, types) if pair[1].kind not in "biuf"])
    # The columns of one block are a view.
    blocks = getattr(getattr(a, "_mgr", None), "nblocks", 0)
    if not types or blocks == 1 and isinstance(types[0], np.dtype):
        return None

    def rows(first: int, count: int) -> NDArray[Any]:
        block = a.iloc[first : first + count]
        return np.asarray(block.to_numpy(dtype=scalar, na_value=np.nan))

    is_single = all(kind.kind == "f" and kind.itemsize <= 4 for kind in types)
    scalar = np.float32 if is_single else np.float64
    return Frame(a.shape, is_single, rows)


def numbers(column: Any) -> NDArray[Any]:
    """Returns a column as numbers; NaN for missing ones."""
    entries = np.asarray(column)
    # Truth values and decimals, with None where one is missing.
    return entries if entries.dtype.kind in "biuf" else entries.astype(np.float64)


def refuse(name: str, others: List[Tuple[Any, Any]]) -> None:
    """Refuses the first column that has no numbers, given by its name and its type."""
    if others:
        column, kind = others[0]
        raise TypeError(f"{name}: column {column} has {kind}, where numbers are needed")
