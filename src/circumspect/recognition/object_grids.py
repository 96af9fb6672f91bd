"""The occupancy grids of the object that a classifier requires."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Classifier
from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid, hits_views
from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.reconstruction import GrowingOccupancy, ObjectModel

MAX_SHIFT_CELLS = 0.25
"""Grids of a growing object stay in place up to this distance from a new fit [cells], which is the
offset of further grids; no ray is then traced twice."""
SECTORS = 72
SECTOR_RAD = 2 * np.pi / SECTORS
"""Width of a sector."""
HALF_VIEW = SECTORS // 8
"""Number of sectors to either side of a view that it observes: those facing it within 45°."""
FACING = (np.arange(SECTORS)[:, None] + np.arange(1 - HALF_VIEW, 1 + HALF_VIEW)) % SECTORS
"""(72, 18) borders between sectors within 45° of each sector's middle; border k is the start of
sector k."""


class ObjectGrids:
    """Fits grids to an object model, fills them and measures the coverage.

    Attributes:
        grids: The grids of the latest model; the first is ray traced. Empty before the first
            model that could be gridded, and after one that is too wide.
        coverage: Fraction of the azimuth from which the object has been seen, 0 … 1.
        points_xyz: (n, 3) [m] points of the latest model; None before the first.
    """

    def __init__(self, classifier: Classifier) -> None:
        """Start without grids.

        Args:
            classifier: Its input specification defines the grids.
        """
        self.grids: tuple[OccupancyGrid, ...] = ()
        self.coverage = 0.0
        self.points_xyz: NDArray[np.float64] | None = None
        self._input_spec = classifier.input_spec
        self._bounds: Grid | None = None
        self._first, self._further = GrowingOccupancy(), GrowingOccupancy()

    @property
    def first(self) -> OccupancyGrid | None:
        """The ray-traced grid, if there is one."""
        return self.grids[0] if self.grids else None

    def update(self, model: ObjectModel, max_views: int) -> FrameOutcome | None:
        """Grid the preview of a growing model, and measure its coverage.

        Args:
            model: The object's model.
            max_views: Maximum number of grids.

        Returns:
            Why the model cannot be classified; None if it can.
        """
        return self._filled(model, model.preview, max_views)

    def finalise(self, model: ObjectModel) -> FrameOutcome | None:
        """Fill all grids that the classifier requires, fitted again to the full model.

        Args:
            model: The object's model.

        Returns:
            Why the model cannot be classified; None if it can.
        """
        self._bounds = None
        return self._filled(model, model, None)

    def _filled(
        self, model: ObjectModel, source: ObjectModel, max_views: int | None
    ) -> FrameOutcome | None:
        """Fit and fill the grids; returns why that is not possible, else None."""
        try:
            cloud = source.cloud()
            self.points_xyz = cloud.points_xyz
            fitted = self._input_spec.bounds(cloud)
        except GeometryError:
            return FrameOutcome.TOO_LITTLE
        # Column by column: along rows of two columns it takes milliseconds.
        if max(map(np.ptp, cloud.points_xyz.T[:2])) > model.settings.max_width:
            self.grids = ()
            return FrameOutcome.TOO_WIDE
        if self._bounds is None or not _contains(self._bounds, fitted, self._input_spec.margin):
            self._bounds = fitted
        grids = self._occupancies(self._bounds, max_views, cloud, model)
        if not grids[0].occupied.any():
            return FrameOutcome.TOO_LITTLE
        self.grids = grids
        self.coverage = azimuth_coverage(model.views_xyz, grids[0])
        return None

    def _occupancies(
        self, bounds: Grid, max_views: int | None, cloud: PointCloud, model: ObjectModel
    ) -> tuple[OccupancyGrid, ...]:
        """Occupancy of all grids; further ones are ray traced if the classifier uses visibility."""
        if max_views is None:
            grid = model.occupancy(bounds)
        else:
            (grid,) = self._first.update((bounds,), cloud.points_xyz, model.rays)
        # Sub-cell offsets make the answer independent of the cells' origin.
        further = self._input_spec.all_bounds(bounds, max_views)[1:]
        if not further:
            return (grid,)
        if not self._input_spec.visibility:
            return (grid, *_filled_by_hits(further, cloud.points_xyz))
        if max_views is None:
            return (grid, *model.occupancies(further))
        return (grid, *self._further.update(further, cloud.points_xyz, model.rays))


def _contains(bounds: Grid, fitted: Grid, margin: float) -> bool:
    """Whether bounds still contain an object and are near the bounds fitted to it."""
    if not (isinstance(bounds, CylindricalGrid) and isinstance(fitted, CylindricalGrid)):
        return False
    rings, _, layers = fitted.shape
    x, y, z = np.abs(np.subtract(fitted.centre_xyz, bounds.centre_xyz))
    offset, wider = float(np.hypot(x, y)), fitted.radius - bounds.radius
    taller = fitted.half_height - bounds.half_height
    width, height = fitted.radius / rings, 2 * fitted.half_height / layers
    near = max(offset, abs(wider)) / width, max(z, abs(taller)) / height
    return (
        max(near) <= MAX_SHIFT_CELLS
        and offset + fitted.radius / margin <= bounds.radius
        and z + fitted.half_height / margin <= bounds.half_height
    )


def _filled_by_hits(grids: Sequence[Grid], points_xyz: NDArray[np.float64]) -> list[OccupancyGrid]:
    """Occupancy of further grids by hits; cylindrical ones in one pass."""
    if not (grids and isinstance(grids[0], CylindricalGrid)):
        return [grid.hits(points_xyz, threads=0) for grid in grids]
    states = hits_views(grids, points_xyz)
    return [OccupancyGrid(*view) for view in zip(grids, states, strict=True)]


def azimuth_coverage(views_xyz: NDArray[np.floating], grid: OccupancyGrid) -> float:
    """Fraction of the azimuth around the object's axis that is within 45° of some view.

    Args:
        views_xyz: (f, 3) [m] camera positions of the frames.
        grid: The object's grid; its axis is the object's.

    Returns:
        0 without views, 0.25 for a single view, 1 for views all round.
    """
    offset = views_xyz[:, :2] - np.asarray(grid.grid.centre_xyz[:2])
    bearings = np.arctan2(offset[:, 1], offset[:, 0])
    # Views nearest to the same border observe the same sectors.
    from_border = np.zeros(SECTORS, bool)
    from_border[np.rint(bearings / SECTOR_RAD).astype(np.intp) % SECTORS] = True
    return float(from_border[FACING].any(axis=1).mean())
