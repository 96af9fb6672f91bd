"""Where the robot has to stand so that its camera sees what it should."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.planning.plan_view import centre_of, thinned
from circumspect.planning.situation import Situation

SURFACE_DISTANCE = 0.8
"""Level distance of camera and surface [m] (section 3.1)."""
IMAGE_SHARE = 0.95
"""Share of the image that the object may fill along each side."""
STEP = 0.05
"""Distances are tried in steps of this [m]."""
FARTHEST = 10.0
"""Larger distances are not tried [m], however far the camera measures."""
TOLERATED = 0.01
"""So much of the object may stay outside the image if a larger distance gains no more."""
MOST_POINTS = 600


def planar_mounting(T_base_camera: RigidTransform) -> PlanarPose:
    """Place of the camera in the base and heading of its axis, seen from above."""
    matrix = T_base_camera.as_matrix()
    yaw = np.arctan2(matrix[1, 2], matrix[0, 2])
    return PlanarPose(float(matrix[0, 3]), float(matrix[1, 3]), float(yaw))


def camera_place(T_map_base: PlanarPose, T_base_camera: RigidTransform) -> PlanarPose:
    """The camera seen from above: its place, and the heading of its axis."""
    return T_map_base @ planar_mounting(T_base_camera)


def stance(
    camera_xy: ArrayLike, towards_xy: ArrayLike, T_base_camera: RigidTransform
) -> PlanarPose:
    """Where the base stands when its camera is at a place and looks towards another.

    Args:
        camera_xy: (2,) [m].
        towards_xy: (2,) [m].
        T_base_camera: Where the camera is mounted.

    Returns:
        `T_map_base`.
    """
    camera, towards = np.asarray(camera_xy, float), np.asarray(towards_xy, float)
    yaw = float(np.arctan2(*(towards - camera)[::-1]))
    wanted = PlanarPose(float(camera[0]), float(camera[1]), yaw)
    return wanted @ planar_mounting(T_base_camera).inverse()


def fitting_distance(
    situation: Situation, outward_xy: NDArray[np.float64], least: float = SURFACE_DISTANCE
) -> float:
    """How far from the object the camera has to be on one side of it.

    Args:
        situation: The object so far, camera and mounting.
        outward_xy: (2,) unit vector from the object's centre to that side.
        least: The distance of objects that fit the image anyway [m].

    Returns:
        The smallest level distance, from the outermost point on that side, at which what is known
        of the object fits image and range as well as it does at any distance [m].
    """
    points = thinned(situation.points_xyz, MOST_POINTS)
    centre = centre_of(points)
    reach = float(((points[:, :2] - centre) @ outward_xy).max())
    most = min(situation.depth_range[1], FARTHEST)
    distances = np.arange(least, max(most, least + STEP), STEP)
    outside = _shares_outside(situation, points, centre, reach + distances, outward_xy)
    return float(distances[int(np.argmax(outside <= outside.min() + TOLERATED))])


def _shares_outside(
    situation: Situation,
    points_xyz: NDArray[np.float64],
    centre_xy: NDArray[np.float64],
    away: NDArray[np.float64],
    outward_xy: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(k,) shares of the (n, 3) points that the camera, (k,) `away` from the centre, misses."""
    mounting, camera = situation.T_base_camera, situation.camera
    base = stance(centre_xy + outward_xy, centre_xy, mounting)
    T_camera_map = (base.as_transform() * mounting).inv()
    # Stepping back moves every point by the same vector in the camera's frame.
    step_back = T_camera_map.rotation.apply([*outward_xy, 0.0])
    seen = T_camera_map.apply(points_xyz) - (away[:, None, None] - 1) * step_back
    x, y, z = np.moveaxis(seen, 2, 0)
    inside = (z >= situation.depth_range[0]) & (z <= situation.depth_range[1])
    z = np.maximum(z, 1e-6)
    inside &= np.abs(camera.fx * x / z) <= IMAGE_SHARE * camera.width / 2
    inside &= np.abs(camera.fy * y / z) <= IMAGE_SHARE * camera.height / 2
    return 1 - inside.mean(axis=1)
