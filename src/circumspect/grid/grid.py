"""What both kinds of grid share: bounds around an object, divided into cells."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.grid.grid_arguments import (
    checked_beams,
    checked_points,
    checked_threads,
    require_usable,
)
from circumspect.grid.occupancy_grid import FREE, OCCUPIED, OccupancyGrid


class Grid(ABC):
    """Bounds and resolution; frozen. What is inside a cell is an `OccupancyGrid`."""

    shape: tuple[int, int, int]
    centre_xyz: tuple[float, float, float]

    @abstractmethod
    def kernels(self) -> Any:
        """The C++ grid of these bounds."""

    @abstractmethod
    def recentred(self, centre_xyz: ArrayLike = (0.0, 0.0, 0.0)) -> Self:
        """The same grid about another centre, (3,) [m]."""

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """The same grid in another unit: its bounds and its centre times a factor above 0."""

    def indices(self, points_xyz: PointCloud | ArrayLike, threads: int = 1) -> NDArray[np.int32]:
        """The cell of each point.

        Args:
            points_xyz: (n, 3) [m].
            threads: 0 means all cores.

        Returns:
            (n, 3) int32; -1 in all three columns for points outside. Points exactly on the outer
            boundary belong to the last cell.

        Raises:
            InputError: Wrong shape.
            GeometryError: NaN or infinite coordinates.
        """
        points = checked_points(points_xyz)
        cells = np.empty(points.shape, np.int32)
        bad = self.kernels().indices(points, cells, checked_threads(threads))
        require_usable(bad, len(points))
        return cells

    def hits(self, points_xyz: PointCloud | ArrayLike, threads: int = 1) -> OccupancyGrid:
        """Occupancy by hits, equation 3: occupied where at least one beam ends, else unknown.

        Args:
            points_xyz: (n, 3) [m] the ends of the beams.
            threads: 0 means all cores.

        Raises:
            InputError: Wrong shape.
            GeometryError: NaN or infinite coordinates.
        """
        points = checked_points(points_xyz)
        states = np.zeros(self.shape, np.uint8)
        bad = self.kernels().hits(points, states, OCCUPIED, checked_threads(threads))
        require_usable(bad, len(points))
        return OccupancyGrid(self, states)

    def trace(
        self,
        origins_xyz: ArrayLike,
        ends_xyz: PointCloud | ArrayLike,
        returned: ArrayLike | None = None,
        threads: int = 1,
    ) -> OccupancyGrid:
        """Occupancy by ray tracing with the ideal beam model, in three states.

        Each beam is followed exactly from cell to cell; occupied wins over free wins over
        unknown. Beams may begin, end or run outside the grid.

        Args:
            origins_xyz: (3,) or (n, 3) [m] where the sensor was.
            ends_xyz: (n, 3) [m] where the beams end.
            returned: (n,) bool: False for beams that only passed, up to their end, and hit
                nothing there. None means that all hit.
            threads: 0 means all cores.

        Raises:
            InputError: Wrong shapes.
            GeometryError: NaN or infinite coordinates.
        """
        origins, ends = checked_beams(origins_xyz, ends_xyz)
        hit = ends if returned is None else ends[_checked_mask(returned, len(ends))]
        states = np.zeros(self.shape, np.uint8)
        kernels, cores = self.kernels(), checked_threads(threads)
        bad = kernels.passed(origins, ends, states, FREE, cores)
        require_usable(bad, len(ends), "beams")
        kernels.hits(hit, states, OCCUPIED, cores)
        return OccupancyGrid(self, states)


def _checked_mask(returned: ArrayLike, count: int) -> NDArray[np.bool_]:
    mask = np.asarray(returned)
    if mask.shape != (count,) or mask.dtype != np.bool_:
        raise InputError(
            f"returned must be bool of shape ({count},), not {mask.dtype} {mask.shape}"
        )
    return mask
