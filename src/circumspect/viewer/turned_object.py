"""Classification of the rotated object, to check that the answer is invariant to rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from circumspect.classification import Classifier, Prediction
from circumspect.errors import CircumspectError
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid
from circumspect.viewer.dashboard_state import ObjectSnapshot


@dataclass(frozen=True, eq=False)
class TurnedObject:
    """The rotated object and its answer.

    Attributes:
        yaw: Angle of rotation [rad].
        grid: Grid of the rotated points; its bounds are not rotated.
        prediction: The answer for that grid.
    """

    yaw: float
    grid: OccupancyGrid
    prediction: Prediction


def turned_object(
    snapshot: ObjectSnapshot, yaw: float, classifier: Classifier
) -> TurnedObject | None:
    """Rotate the points, grid and classify them again; None if the object has no grid.

    Args:
        snapshot: The object.
        yaw: Angle, counter-clockwise seen from above [rad].
        classifier: Classifies the rotated object.
    """
    if snapshot.grid is None or len(snapshot.points_xyz) == 0:
        return None
    bounds = snapshot.grid.grid
    centre = np.asarray(bounds.centre_xyz)
    points = Rotation.from_euler("z", yaw).apply(snapshot.points_xyz - centre) + centre
    grid = bounds.hits(points)
    try:
        prediction = classifier.classify_grid(grid, metric=True)
    except CircumspectError:
        # A classifier of points or of other grids gets the cloud.
        prediction = classifier.classify(PointCloud(points), metric=True)
    return TurnedObject(yaw, grid, prediction)
