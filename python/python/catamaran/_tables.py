"""Files of matrices: text tables, .npy and MatrixMarket."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _catamaran
from ._options import Path, Progress, callback, is_sparse, to_scipy, warn_caller
from ._show import table
from ._words import FileFormat, MissingCells

__all__ = ["Table", "read"]


class Factor(NamedTuple):
    """A column of words: what `pandas.Categorical` calls so."""

    #: The different words, sorted by their bytes.
    categories: List[str]
    #: For each row the place of its word; -1 where it is missing.
    codes: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Table:
    """A matrix that `read` has read, and what is known about its columns."""

    #: The entries, m x n: an array, also a complex one, or a `scipy.sparse.csr_array` of a file of
    #: real coordinates.
    values: Any
    #: The names of the columns; empty without a header.
    names: List[str]
    #: The numbers of the columns in the file, from 0; empty for a file of coordinates.
    numbers: List[int]
    #: The levels of each factor, by the place of its column: entry i stands for level i.
    levels: Dict[int, List[str]]
    #: The columns of words that were left out.
    left_out: List[str]
    #: Rows that were left out because a cell is missing.
    dropped_rows: int
    #: What was decided about a text table, and which integers were rounded, in words; else empty.
    reading: str

    def __str__(self) -> str:
        if is_sparse(self.values):
            return str(self.values)
        names = self.names or [str(number) for number in self.numbers]
        return table({name: self.values[:, j] for j, name in enumerate(names)})

    def factor(self, column: Union[int, str]) -> Factor:
        """Returns a factor, given by its name or its place, as `lstsq` takes it."""
        place = column
        if isinstance(column, str) and column in self.names:
            place = self.names.index(column)
        if isinstance(place, str) or place not in self.levels:
            raise ValueError(f"column {column}: not a factor of this table")
        entries = self.values[:, place]
        codes = np.where(np.isnan(entries), -1, entries).astype(np.intp)
        return Factor(self.levels[place], codes)


def read(
    path: Path,
    *,
    columns: Union[None, int, str, range, Sequence[Union[int, str]]] = None,
    separator: Optional[str] = None,
    decimal: Optional[str] = None,
    thousands: Optional[str] = None,
    header: Optional[bool] = None,
    skip: int = 0,
    comment: Optional[str] = None,
    missing: MissingCells = "error",
    missing_words: Optional[Sequence[str]] = None,
    index: Optional[bool] = None,
    encoding: Optional[str] = None,
    format: Optional[FileFormat] = None,
    factors: Union[bool, int, str, Sequence[Union[int, str]]] = False,
    max_memory: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Table:
    """Reads a matrix from a text table, .npy or MatrixMarket, each also packed (.gz, .xz,
    .bz2, .zst, .zip), or from Parquet or Arrow (Feather).

    By default the beginning of a table decides how it is read. Where that leaves two ways open,
    an error names the option that decides.

    Parameters
    ----------
    path : path
        The file.
    columns : int, str, range, or sequence of int and str, optional
        Columns to keep: numbers counted from 0 over all columns of the file, or names. A string is
        what the command line takes: a name, a number, a range "2..5" without its end, or a list of
        these between commas.
    separator : str, optional
        The character between fields; a blank stands for runs of blanks and tabs.
    decimal : str, optional
        The decimal separator: "." or ",".
    thousands : str, optional
        The separator of groups of three digits: ",", ".", " " or "'".
    header : bool, optional
        Whether the first row has the names of the columns.
    skip : int
        Number of lines at the start that are left out.
    comment : str, optional
        The character that starts a comment.
    missing : {"error", "drop", "nan"}
        What becomes of a row with a missing cell in a column that is kept.
    missing_words : sequence of str, optional
        The words of missing cells, instead of those of pandas.
    index : bool, optional
        Whether the first column numbers or names the rows, and is left out.
    encoding : str, optional
        The encoding of text.
    format : {"npy", "mtx", "table", "parquet", "arrow"}, optional
        The format, whatever the name of the file ends in.
    factors : bool, int, str, or sequence of int and str
        Whether columns of words become factors: numbers of their levels. Otherwise they are left
        out. A sequence, or a string with commas, names the columns that become factors if one of
        their entries is a word.
    max_memory : int, optional
        Bytes of memory that the file may take.
    threads : int, optional
        Number of threads. The result does not depend on it.
    progress : callable or tqdm, optional
        Told of progress.

    Returns
    -------
    Table
        The matrix, and what is known about its columns.

    Warns
    -----
    UserWarning
        Says what was decided, unless the table is a plain one.

    Raises
    ------
    OSError
        Names the file, the line, the column, and the option that decides.
    ValueError
        An option is out of its range, or a column or factor does not exist.

    Examples
    --------
    >>> import os, tempfile
    >>> import catamaran
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "a.csv")
    ...     with open(path, "w") as file:
    ...         _ = file.write("x,y\\n1,2\\nNA,3\\n4,5\\n")
    ...     table = catamaran.read(path, columns=["y"])
    >>> table.names, table.values.ravel().tolist()
    (['y'], [2.0, 3.0, 5.0])
    """
    if isinstance(factors, str):
        factors = [name.strip() for name in factors.split(",")]
    wanted = [] if isinstance(factors, bool) else listed(factors) or []
    options = {
        "columns": columns if isinstance(columns, str) else listed(columns),
        "separator": separator,
        "decimal": decimal,
        "thousands": thousands,
        "header": header,
        "skip": skip,
        "comment": comment,
        "missing": missing,
        "missing_words": listed(missing_words),
        "index": index,
        "encoding": encoding,
        "format": format,
        "words": factors is True,
        "factors": wanted,
        "max_memory": max_memory,
        "threads": threads,
    }
    found = _catamaran.read(path, options, callback(progress))
    known = [*found["names"], *map(str, found["numbers"])]
    for name in wanted:
        if name not in known:
            more = ", ..." if len(known) > 20 else ""
            those = ", ".join(known[:20]) + more
            raise ValueError(f"factors: no column {name} is read; the columns are {those}")
    if not found.get("is_plain", True):
        warn_caller(f"{os.fspath(path)}: {found['reading']}")
    if "sparse" in found:
        values = to_scipy(found["sparse"])
    elif "imaginary" in found:
        # A product with 1j would make NaN of infinite parts.
        values = found["values"].astype(np.complex128)
        values.imag = found["imaginary"]
    else:
        values = found["values"]
    return Table(
        values,
        found["names"],
        found["numbers"],
        found["levels"],
        found.get("left_out", []),
        found.get("dropped_rows", 0),
        found.get("reading", ""),
    )


def listed(
    columns: Union[None, int, str, range, Sequence[Union[int, str]]],
) -> Optional[List[str]]:
    """Returns columns, or words, as the extension takes them: a list, with numbers as text."""
    if columns is None:
        return None
    if isinstance(columns, (str, int, np.integer)):
        return [str(columns)]
    return [str(column) for column in columns]
