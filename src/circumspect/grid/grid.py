"""Bounds around an object in cells, and the state of each cell."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.grid.grid_arguments import (
    checked_beams,
    checked_points,
    checked_threads,
    require_usable,
)
from circumspect.grid.grid_file import read_grid, write_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
"""States of a cell: unobserved, traversed by a beam, or hit by one. The largest one wins."""


class Grid(ABC):
    """Bounds and resolution; frozen. The content of the cells is an `OccupancyGrid`.

    Attributes:
        bounds_names: The bounds beside shape and centre in a file; they differ between the kinds of
            grid.
    """

    bounds_names: ClassVar[tuple[str, ...]]
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

    @abstractmethod
    def draw(self, axes: Axes, cells: OccupancyGrid, unit: str = "m") -> None:
        """Draw the cells; see `OccupancyGrid.plot`.

        Args:
            axes: Where to draw.
            cells: Of this grid.
            unit: Of the bounds, as the axes name it.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """

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

        Each beam is followed exactly from cell to cell; occupied wins over free, free over unknown.
        Beams may begin, end or run outside the grid.

        Args:
            origins_xyz: (3,) or (n, 3) [m] where the sensor was.
            ends_xyz: (n, 3) [m] where the beams end.
            returned: (n,) bool: False for beams that traversed cells up to their end without a
                hit. None means that all hit.
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
        """Both observations of the same cells: occupied wins over free, free over unknown.

        Raises:
            InputError: The grids differ.
        """
        if self.grid != other.grid:
            raise InputError("only grids of the same bounds can be merged; trace both on one grid")
        return OccupancyGrid(self.grid, np.maximum(self.states, other.states))

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the outermost surface over azimuth and height; of a rectangular grid the plan.

        Args:
            axes: Where to draw; None for a new figure.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        from circumspect.figure_canvas import axes_or_new

        axes = axes_or_new(axes)
        self.grid.draw(axes, self)
        return axes

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz of packed bits and bounds.

        Raises:
            OutputError: The file cannot be written.
        """
        numbers = {name: getattr(self.grid, name) for name in self.grid.bounds_names}
        write_grid(path, self.grid.shape, self.grid.centre_xyz, numbers, self.occupied, self.free)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> OccupancyGrid:
        """Read what `save` wrote.

        Raises:
            InputError: Missing, truncated, or not a grid.
        """
        kinds = {kind.bounds_names: kind for kind in Grid.__subclasses__()}
        grid, occupied, free = read_grid(path, kinds)
        return OccupancyGrid(grid, OCCUPIED * occupied + FREE * free)


def _checked_mask(returned: ArrayLike, count: int) -> NDArray[np.bool_]:
    mask = np.asarray(returned)
    if mask.shape != (count,) or mask.dtype != np.bool_:
        raise InputError(
            f"returned must be bool of shape ({count},), not {mask.dtype} {mask.shape}"
        )
    return mask
