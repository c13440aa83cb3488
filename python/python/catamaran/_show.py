"""Tables of results as text, and axes of matplotlib to draw them on."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

__all__ = ["axes", "table"]

#: Rows of a table, at most; those in the middle are left out.
MOST_ROWS = 20


def table(columns: Mapping[str, Sequence[Any]]) -> str:
    """Returns columns of equal lengths, with their names, as lines of text."""
    count = min((len(column) for column in columns.values()), default=0)
    shown = list(range(count))
    if count > MOST_ROWS:
        shown[MOST_ROWS // 2 : -(MOST_ROWS // 2)] = [-1]
    cells = [
        [name] + ["..." if i < 0 else text(column[i]) for i in shown]
        for name, column in columns.items()
    ]
    widths = [max(map(len, column)) for column in cells]
    lines = (
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in zip(*cells)
    )
    return "\n".join(lines)


def text(value: Any) -> str:
    """Returns a number with six digits, anything else as it is."""
    return value if isinstance(value, str) else f"{value:.6g}"


def axes(ax: Any, **more: Any) -> Any:
    """Returns the axes to draw on: `ax`, or those of a new figure of matplotlib.

    Raises
    ------
    ImportError
        When matplotlib is not installed.
    """
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("plot: matplotlib is not installed: pip install matplotlib") from error
    return plt.subplots(subplot_kw=more, layout="constrained")[1]
