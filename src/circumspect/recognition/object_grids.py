"""The occupancy grids of the object that a classifier asks for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Classifier
from circumspect.errors import GeometryError
from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid, hits_views
from circumspect.recognition.azimuth_coverage import azimuth_coverage
from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.reconstruction import ObjectModel


class ObjectGrids:
    """Fits grids to an object model, fills them and measures the coverage.

    Attributes:
        grids: The grids of the latest model. The first is ray traced. Empty before the first
            model that could be gridded, and after one that is too wide.
        coverage: Share of the azimuth from which the object has been seen, 0 … 1.
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
        self._classifier = classifier

    @property
    def first(self) -> OccupancyGrid | None:
        """The ray-traced grid, if there is one."""
        return self.grids[0] if self.grids else None

    def update(self, model: ObjectModel, max_views: int | None = None) -> FrameOutcome | None:
        """Grid a model and measure its coverage.

        Args:
            model: The object's model, or its preview.
            max_views: Maximum number of grids; None means all that the classifier asks for.

        Returns:
            Why the model cannot be classified; None if it can.
        """
        outcome = self._fill(model, max_views)
        if outcome is FrameOutcome.TOO_WIDE:
            self.grids = ()
        if self.first is not None:
            self.coverage = azimuth_coverage(model.views_xyz, self.first)
        return outcome

    def _fill(self, model: ObjectModel, max_views: int | None) -> FrameOutcome | None:
        """Fit and fill the grids; returns why that is not possible, else None."""
        recipe = self._classifier.recipe
        try:
            cloud = model.cloud()
            self.points_xyz = cloud.points_xyz
            bounds = recipe.bounds(cloud)
        except GeometryError:
            return FrameOutcome.TOO_LITTLE
        # One column after the other: along the rows of two columns it takes milliseconds.
        if max(map(np.ptp, cloud.points_xyz.T[:2])) > model.settings.max_width:
            return FrameOutcome.TOO_WIDE
        grid = model.occupancy(bounds)
        if not grid.occupied.any():
            return FrameOutcome.TOO_LITTLE
        # Sub-cell offsets make the answer independent of where the cells begin.
        further = recipe.all_bounds(bounds, max_views)[1:]
        if recipe.visibility and further:
            self.grids = (grid, *model.occupancies(further))
        else:
            self.grids = (grid, *_filled_by_hits(further, cloud.points_xyz))
        return None


def _filled_by_hits(grids: Sequence[Grid], points_xyz: NDArray[np.float64]) -> list[OccupancyGrid]:
    """Occupancy of further grids by hits; cylindrical ones in one pass."""
    if not (grids and isinstance(grids[0], CylindricalGrid)):
        return [grid.hits(points_xyz, threads=0) for grid in grids]
    states = hits_views(grids, points_xyz)
    return [OccupancyGrid(*view) for view in zip(grids, states, strict=True)]
