"""The object turned about its axis, gridded and named anew: the answer should stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from circumspect.classification import Classifier, Prediction
from circumspect.errors import CircumspectError
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid
from circumspect.viewer.shown import ShownObject


@dataclass(frozen=True, eq=False)
class TurnedObject:
    """What comes out.

    Attributes:
        yaw: By how much it was turned [rad].
        grid: Of the turned points; its bounds do not turn.
        prediction: The answer to that grid.
    """

    yaw: float
    grid: OccupancyGrid
    prediction: Prediction


def turned_object(thing: ShownObject, yaw: float, classifier: Classifier) -> TurnedObject | None:
    """Turn the points themselves and grid them anew; None where there is no grid to turn in.

    Args:
        thing: The object.
        yaw: Counter-clockwise, seen from above [rad].
        classifier: Names it.
    """
    if thing.grid is None or len(thing.points_xyz) == 0:
        return None
    bounds = thing.grid.grid
    centre = np.asarray(bounds.centre_xyz)
    points = Rotation.from_euler("z", yaw).apply(thing.points_xyz - centre) + centre
    grid = bounds.hits(points)
    try:
        prediction = classifier.classify_grid(grid, metric=True)
    except CircumspectError:
        # A classifier of points, or of other grids: it is shown the cloud.
        prediction = classifier.classify(PointCloud(points), metric=True)
    return TurnedObject(yaw, grid, prediction)
