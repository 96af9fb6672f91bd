"""What is known of each cell."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.frozen_array import ReadOnlyArrays

if TYPE_CHECKING:
    from circumspect.grid.grid import Grid

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
"""States of a cell: no beam came there, beams passed, a beam ended. The larger one wins."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid(ReadOnlyArrays):
    """The state of every cell of a grid; the array is read-only.

    Attributes:
        grid: The bounds and the kind of the cells.
        states: uint8 of the grid's shape: `UNKNOWN`, `FREE` or `OCCUPIED`.

    Raises:
        InputError: Another shape or dtype than the grid's, or other values.
    """

    grid: Grid
    states: NDArray[np.uint8]

    def __post_init__(self) -> None:
        states = np.asarray(self.states)
        if states.shape != self.grid.shape:
            raise InputError(
                f"states must have the grid's shape {self.grid.shape}, not {states.shape}"
            )
        if states.dtype != np.uint8:
            raise InputError(f"states must be uint8, not {states.dtype}")
        if states.max() > OCCUPIED:
            raise InputError(f"states must be 0, 1 or 2, not {states.max()}")
        if states.flags.writeable:
            states = states.view()
            states.flags.writeable = False
        object.__setattr__(self, "states", states)

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """The paper's binary grid: True where a beam ended; of the grid's shape."""
        return self.states == OCCUPIED

    @property
    def free(self) -> NDArray[np.bool_]:
        """True where beams passed and none ended; of the grid's shape."""
        return self.states == FREE

    def merged(self, other: OccupancyGrid) -> OccupancyGrid:
        """Both observations of the same cells: occupied wins over free wins over unknown.

        Raises:
            InputError: The grids differ.
        """
        if self.grid != other.grid:
            raise InputError("only grids of the same bounds can be merged; trace both on one grid")
        return OccupancyGrid(self.grid, np.maximum(self.states, other.states))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz of packed bits and bounds.

        Raises:
            OutputError: The file can not be written.
        """
        from circumspect.grid.grid_file import write_grid

        write_grid(path, self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> OccupancyGrid:
        """Read what `save` wrote.

        Raises:
            InputError: Missing, truncated, or not a grid.
        """
        from circumspect.grid.grid_file import read_grid

        return read_grid(path)
