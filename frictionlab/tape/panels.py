"""A matrix as panels of rows, whose sums are computed side by side.

A panel has the entries of `ROWS` rows, column after column: those of one column are loaded as vectors.
Columns that are zero in all rows of a panel are left out.  Each row is a sum in the sequence of the columns,
as if it stood alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

ROWS = 16  # of a panel; rows of zeros fill up the last one


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a matrix."""

    starts: list[int]  # (panels + 1,) range of each panel's columns in `columns`
    columns: NDArray[np.intp]
    entries: NDArray[np.float64]  # ROWS for each of these


_MADE: WeakKeyDictionary[Any, Panels] = WeakKeyDictionary()  # of products that are in use


def range_of_columns(a: int, b: int) -> tuple[int, int]:
    """The range of the columns of a panel, where a row of it has every ROWS-th term of [a, b)."""
    return a // ROWS, b // ROWS + (b % ROWS > a % ROWS)


def panels_of(product: Any) -> Panels:
    """The panels of the matrix of a product (:class:`~frictionlab.automaton.matrix_rows.MatrixProduct`)."""
    owner = product if product.like is None else product.like
    if owner not in _MADE:
        _MADE[owner] = _panels(owner.matrix)
    return _MADE[owner]


def _panels(matrix: NDArray[np.float64]) -> Panels:
    blocks = [matrix[first : first + ROWS] for first in range(0, len(matrix), ROWS)]
    columns = [np.flatnonzero(block.any(axis=0)) for block in blocks]
    entries = np.zeros((sum(map(len, columns)), ROWS))
    starts = [0]
    for block, nonzero in zip(blocks, columns, strict=True):
        starts.append(starts[-1] + len(nonzero))
        entries[starts[-2] : starts[-1], : len(block)] = block[:, nonzero].T
    return Panels(starts, np.concatenate([*columns, np.zeros(0, dtype=np.intp)]), entries.ravel())
