"""Where the robot may drive: a grid over the floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.planning.situation import Situation

CELL = 0.05
"""Side of the cells [m]."""
MARGIN = 1.5
"""So far beyond everything known there is floor to drive on [m]."""
FARTHEST = 1e3
"""Where nothing is known everything is this far away [m]."""
SAFETY = 0.05
"""The robot stays this far from things, beyond its radius [m]."""


@dataclass(frozen=True, eq=False)
class Costmap:
    """Distances to what stands on the floor, cell by cell.

    Attributes:
        low_xy: (2,) [m] corner of the cell (0, 0).
        to_object: (nx, ny) [m] from the cell's middle to the object; 0 in it and in its hull.
        to_obstacle: (nx, ny) [m] the same for everything else.
        radius: The robot can be where both are at least this [m].
    """

    low_xy: NDArray[np.float64]
    to_object: NDArray[np.float64]
    to_obstacle: NDArray[np.float64]
    radius: float

    @classmethod
    def of(cls, situation: Situation, *places_xy: NDArray[np.float64]) -> Costmap:
        """Map what is known.

        The object's convex hull counts as object: nobody drives between the legs of a table, and
        the side not seen yet is no way through.

        Args:
            situation: Object, obstacles and robot.
            places_xy: (2,) each [m] places that must lie on the map.
        """
        flat = situation.footprint_xy
        everything = np.vstack([flat, situation.T_map_base.xy, *places_xy])
        low = everything.min(axis=0) - MARGIN
        shape = np.ceil((everything.max(axis=0) + MARGIN - low) / CELL).astype(int)
        middles = low + (np.indices(shape).transpose(1, 2, 0) + 0.5) * CELL
        thing = _marked(flat, low, shape) | _in_hull(flat, middles)
        other = _marked(situation.obstacles_xy, low, shape)
        radius = situation.robot_radius + SAFETY
        return cls(low, _distance(thing), _distance(other), radius)

    @property
    def free(self) -> NDArray[np.bool_]:
        """(nx, ny) the cells where the robot's middle may be."""
        return np.minimum(self.to_object, self.to_obstacle) >= self.radius

    def clearance(self, places_xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) [m] from (n, 2) places to the nearest thing, between the cells' middles, too."""
        from scipy import ndimage

        # Finite, for nothing may be known to interpolate from.
        nearest = np.minimum(np.minimum(self.to_object, self.to_obstacle), FARTHEST)
        at = (places_xy - self.low_xy) / CELL - 0.5
        return ndimage.map_coordinates(nearest, at.T, order=1, mode="nearest")

    def cell(self, place_xy: NDArray[np.float64]) -> tuple[int, int]:
        """The cell of a (2,) place [m] on the map."""
        x, y = np.floor((np.asarray(place_xy) - self.low_xy) / CELL).astype(int)
        return int(x), int(y)

    def middles(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """(n, 2) [m] the middles of (n, 2) cells."""
        return self.low_xy + (cells + 0.5) * CELL


def _marked(
    places_xy: NDArray[np.float64], low_xy: NDArray[np.float64], shape: NDArray[np.integer]
) -> NDArray[np.bool_]:
    """Cells that hold a place; places beyond the map are left out."""
    grid = np.zeros(shape, bool)
    cells = np.floor((places_xy - low_xy) / CELL).astype(int)
    cells = cells[((cells >= 0) & (cells < shape)).all(axis=1)]
    grid[cells[:, 0], cells[:, 1]] = True
    return grid


def _in_hull(
    footprint_xy: NDArray[np.float64], middles_xy: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Cells in the convex hull; none where the footprint spans no area."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        planes = ConvexHull(footprint_xy).equations
    except (QhullError, ValueError):
        return np.zeros(middles_xy.shape[:2], bool)
    return np.all(middles_xy @ planes[:, :2].T + planes[:, 2] <= 0, axis=-1)


def _distance(marked: NDArray[np.bool_]) -> NDArray[np.float64]:
    """[m] from each cell to the nearest marked one; infinite where there is none."""
    from scipy import ndimage

    if not marked.any():
        return np.full(marked.shape, np.inf)
    return CELL * np.asarray(ndimage.distance_transform_edt(~marked))
