"""Factors: columns of labels, and the columns of zeros and ones that stand for them."""

from __future__ import annotations

from typing import Any, List, Mapping, Tuple

import numpy as np
from numpy.typing import NDArray

from ._frames import refuse_other_rows

__all__ = ["Coded", "Levels", "coded", "indicators", "levels_of", "refuse_other_factors"]

#: A factor: its name, its levels in the order of their codes, and whether the order stays.
Coded = Tuple[str, List[str], bool]
#: The name of each factor and its levels, the base first.
Levels = Tuple[Tuple[str, Tuple[str, ...]], ...]


def coded(factors: Mapping[str, Any]) -> Tuple[List[Coded], Any]:
    """Returns the names and levels of factors, and a column of codes for each, NaN where missing.

    Levels of a pandas categorical, or of anything else with ``categories`` and ``codes``, keep
    their order.
    """
    if not isinstance(factors, Mapping):
        kind = type(factors).__name__
        raise TypeError(f"factors: expected a dict of names and labels, got {kind}")
    found: List[Coded] = []
    columns: List[Any] = []
    for name, of in factors.items():
        # What pandas has there; polars has other things of this name.
        values: Any = getattr(of, "cat", of)
        if hasattr(values, "categories") and hasattr(values, "codes"):
            codes = np.array(values.codes, dtype=np.float64)
            codes[codes < 0] = np.nan
            found.append((name, [str(level) for level in values.categories], True))
            columns.append(codes)
            continue
        # As text, NaN beside words would be a word.
        array = np.asarray(of, dtype=object)
        if array.ndim != 1:
            raise ValueError(f"factors: {name}: expected a vector, got {array.ndim} dimensions")
        labels = array.tolist()
        missing = [is_missing(label) for label in labels]
        known = [str(label) for label, none in zip(labels, missing) if not none]
        levels = {level: k for k, level in enumerate(dict.fromkeys(known))}
        codes = np.array([levels.get(str(label), np.nan) for label in labels], dtype=np.float64)
        codes[np.array(missing, dtype=bool)] = np.nan
        found.append((name, list(levels), False))
        columns.append(codes)
    if len({len(column) for column in columns}) > 1:
        raise ValueError("factors: of different lengths")
    return found, np.column_stack(columns) if columns else None


def refuse_other_factors(a: Any, factors: Mapping[str, Any]) -> None:
    """Refuses labels whose index of pandas is not that of the frame `a`."""
    refuse_other_rows(a, **{f"factors: {name}": labels for name, labels in factors.items()})


def levels_of(factors: List[Coded], codes: Any, columns: List[str]) -> Levels:
    """Returns the names of factors and their levels in rows of `codes`, the base first.

    `columns` are those of all factors, ``name[level]`` for each level but the base.
    """
    found, first = [], 0
    for (name, levels, _), own in zip(factors, np.transpose(codes)):
        there = [levels[int(code)] for code in np.unique(own)]
        last = first + len(there) - 1
        others = [column[len(name) + 1 : -1] for column in columns[first:last]]
        base = [level for level in there if level not in others]
        found.append((name, (*base, *others)))
        first = last
    return tuple(found)


def indicators(levels: Levels, factors: Mapping[str, Any], m: int) -> NDArray[np.float64]:
    """Returns the columns of factors that a fit knows for m rows with these labels, NaN where a
    label is missing."""
    given, codes = coded(factors)
    if {name for name, *_ in given} != {name for name, _ in levels}:
        known = ", ".join(name for name, _ in levels) or "none"
        raise ValueError(f"factors: the fit has {known}, got {', '.join(factors) or 'none'}")
    if codes is not None and len(codes) != m:
        raise ValueError(f"factors: {len(codes)} labels for {m} rows")
    columns: List[Any] = []
    for name, (base, *others) in levels:
        k = [own for own, *_ in given].index(name)
        own, labels = codes[:, k], given[k][1]
        for code in np.unique(own[~np.isnan(own)]):
            if labels[int(code)] not in (base, *others):
                those = ", ".join(repr(level) for level in (base, *others[:7]))
                raise ValueError(f"factors: {name}: {labels[int(code)]!r} is not one of {those}")
        for level in others:
            is_there = own == (labels.index(level) if level in labels else -1)
            columns.append(np.where(np.isnan(own), np.nan, is_there))
    return np.column_stack(columns) if columns else np.empty((m, 0))


def is_missing(label: Any) -> bool:
    """Returns whether a label is None, or NaN, NaT or NA, which do not equal themselves."""
    same = label == label
    # Of the NA of pandas it is NA, which is neither true nor false.
    return label is None or not isinstance(same, (bool, np.bool_)) or not same
