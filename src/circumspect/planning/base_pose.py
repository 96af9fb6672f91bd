"""Base poses from which the camera has a given view."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.planning.plan_view import centre_of, thinned
from circumspect.planning.planner_input import NextView, PlannerInput

SURFACE_DISTANCE_M = 0.8
"""Horizontal distance between camera and surface [m] (section 3.1)."""
MAX_IMAGE_FRACTION = 0.95
"""Fraction of each image side that the object may fill."""
STEP_M = 0.05
"""Step of the tested distances [m]."""
MAX_DISTANCE_M = 10.0
"""Maximum tested distance [m], whatever the range of the camera."""
OUTSIDE_TOLERANCE = 0.01
"""Additional fraction of the object that may be outside the image in favour of a smaller
distance."""
MAX_POINTS = 600
OFFSETS_M = (0.15, -0.15, 0.3, -0.3, 0.5)
"""Changes of the distance in the order of preference [m]; positive is farther away."""
MIN_DISTANCE_M = 0.6
"""Minimum distance between the camera and its target [m]."""


def planar_mounting(T_base_camera: RigidTransform) -> PlanarPose:
    """Pose of the camera in the base, seen from above."""
    matrix = T_base_camera.as_matrix()
    yaw = np.arctan2(matrix[1, 2], matrix[0, 2])
    return PlanarPose(float(matrix[0, 3]), float(matrix[1, 3]), float(yaw))


def camera_place(T_map_base: PlanarPose, T_base_camera: RigidTransform) -> PlanarPose:
    """Pose of the camera seen from above."""
    return T_map_base @ planar_mounting(T_base_camera)


def base_pose(
    camera_xy: ArrayLike, towards_xy: ArrayLike, T_base_camera: RigidTransform
) -> PlanarPose:
    """The base pose at which the camera is at a position and looks towards another.

    Args:
        camera_xy: (2,) position of the camera [m].
        towards_xy: (2,) position that it looks at [m].
        T_base_camera: Mount of the camera.

    Returns:
        `T_map_base`.
    """
    camera, towards = np.asarray(camera_xy, float), np.asarray(towards_xy, float)
    yaw = float(np.arctan2(*(towards - camera)[::-1]))
    wanted = PlanarPose(float(camera[0]), float(camera[1]), yaw)
    return wanted @ planar_mounting(T_base_camera).inverse()


def fitting_distance(
    planner_input: PlannerInput,
    outward_xy: NDArray[np.float64],
    min_distance: float = SURFACE_DISTANCE_M,
) -> float:
    """Distance from the object at which the camera sees all of it from one side.

    Args:
        planner_input: Object, camera and mount.
        outward_xy: (2,) unit vector from the object's centre towards the camera.
        min_distance: Minimum distance [m].

    Returns:
        The smallest horizontal distance from the outermost point on that side at which the known
        part of the object fits image and range as well as at any distance [m].
    """
    points = thinned(planner_input.points_xyz, MAX_POINTS)
    centre = centre_of(points)
    reach = float(((points[:, :2] - centre) @ outward_xy).max())
    most = min(planner_input.depth_range[1], MAX_DISTANCE_M)
    distances = np.arange(min_distance, max(most, min_distance + STEP_M), STEP_M)
    outside = _fractions_outside(planner_input, points, centre, reach + distances, outward_xy)
    return float(distances[int(np.argmax(outside <= outside.min() + OUTSIDE_TOLERANCE))])


def _fractions_outside(
    planner_input: PlannerInput,
    points_xyz: NDArray[np.float64],
    centre_xy: NDArray[np.float64],
    away: NDArray[np.float64],
    outward_xy: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(k,) fractions of (n, 3) points outside the view from (k,) distances `away`."""
    mounting, camera = planner_input.T_base_camera, planner_input.camera
    base = base_pose(centre_xy + outward_xy, centre_xy, mounting)
    T_camera_map = (base.as_transform() * mounting).inv()
    # Moving back shifts all points by the same vector in the camera frame.
    step_back = T_camera_map.rotation.apply([*outward_xy, 0.0])
    seen = T_camera_map.apply(points_xyz) - (away[:, None, None] - 1) * step_back
    x, y, z = np.moveaxis(seen, 2, 0)
    inside = (z >= planner_input.depth_range[0]) & (z <= planner_input.depth_range[1])
    z = np.maximum(z, 1e-6)
    inside &= np.abs(camera.fx * x / z) <= MAX_IMAGE_FRACTION * camera.width / 2
    inside &= np.abs(camera.fy * y / z) <= MAX_IMAGE_FRACTION * camera.height / 2
    return 1 - inside.mean(axis=1)


def alternatives(view: NextView, T_base_camera: RigidTransform) -> Iterator[NextView]:
    """Views along the same line of sight, in case there is no path to the preferred one.

    Args:
        view: The preferred view.
        T_base_camera: Mount of the camera.
    """
    target = np.asarray(view.looks_at_xy)
    sight = camera_place(view.T_map_base, T_base_camera).xy - target
    distance = float(np.linalg.norm(sight))
    for offset in OFFSETS_M:
        if distance + offset >= MIN_DISTANCE_M:
            place = target + sight * (1 + offset / distance)
            base = base_pose(place, target, T_base_camera)
            direction = "farther away" if offset > 0 else "nearer"
            reason = f"{view.reason}, but {abs(offset):.2f} m {direction}"
            yield NextView(base, view.looks_at_xy, view.normal_xy, reason)
