"""How far round the object the robot has come."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.geometry import PlanarPose
from circumspect.planning.plan_view import centre_of
from circumspect.planning.situation import Situation


def bearing_turned(situation: Situation) -> float:
    """Degrees that the robot has gone round the object, counter-clockwise.

    What it went forth and back counts nothing.
    """
    if len(situation.visited) < 2 or len(situation.points_xyz) == 0:
        return 0.0
    centre = centre_of(situation.points_xyz)
    places = np.array([pose.xy for pose in situation.visited])
    bearings = np.unwrap(bearings_of(places, centre))
    return float(np.degrees(bearings[-1] - bearings[0]))


def bearings_of(places_xy: ArrayLike, centre_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) [rad] directions from the centre to (n, 2) places."""
    offset = np.asarray(places_xy, float) - centre_xy
    return np.arctan2(offset[:, 1], offset[:, 0])


def ahead(pose: PlanarPose, other: PlanarPose, centre_xy: NDArray[np.float64]) -> float:
    """Angle [rad] by which `other` is further round than `pose`, in [0, 2π)."""
    first, second = bearings_of([pose.xy, other.xy], centre_xy)
    return float(np.mod(second - first, 2 * np.pi))
