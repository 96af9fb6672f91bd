"""A table of numbers that grows row by row during a long run."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

BLOCK = 256
"""Rows per block."""


class GrowingTable:
    """Stores rows in blocks.

    A small array per row would lie between the large arrays of its frame and outlive them. The heap
    would fragment and grow.
    """

    def __init__(self, columns: int) -> None:
        """Create an empty table.

        Args:
            columns: Numbers in a row.
        """
        self._columns = columns
        self._blocks: list[NDArray[np.float64]] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, row: ArrayLike) -> None:
        """Add a row.

        Args:
            row: As many numbers as there are columns, in any shape.

        Raises:
            ValueError: There are more or fewer.
        """
        numbers = np.asarray(row, np.float64).reshape(self._columns)
        if self._count == BLOCK * len(self._blocks):
            self._blocks.append(np.empty((BLOCK, self._columns)))
        self._blocks[-1][self._count % BLOCK] = numbers
        self._count += 1

    @property
    def rows(self) -> NDArray[np.float64]:
        """(n, columns) a copy of all rows so far."""
        whole = np.concatenate([np.empty((0, self._columns)), *self._blocks])
        return whole[: self._count]
