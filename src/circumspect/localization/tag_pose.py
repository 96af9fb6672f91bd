"""Pose and covariance of the robot from the four corners of its tag in an image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import PlanarPose
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.tag_mount import TagMount

CORNER_SIGMA = 0.06
"""Independent standard deviation of a corner [px]; see docs/intelligent-space.md."""
COMMON_SIGMA = 0.08
"""Common standard deviation of the four corners [px], from light and lens errors."""
MAX_ITERATIONS = 10
MIN_STEP = 1e-10
"""Step below which the iteration ends [m], [rad]."""
REDUNDANCY = 5
"""Degrees of freedom: eight corner coordinates minus three of the pose."""


@dataclass(frozen=True, eq=False)
class TagPose:
    """Pose of the robot measured by one or several cameras.

    Attributes:
        T_map_base: The pose.
        noise: (3, 3) covariance of x, y [m] and yaw [rad] that is independent between images.
        bias: (3, 3) covariance of constant errors of the camera's pose and lens.
        squared_residual: Sum of the corners' squared errors over their variance; 5 on average.
    """

    T_map_base: PlanarPose
    noise: NDArray[np.float64]
    bias: NDArray[np.float64]
    squared_residual: float

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) total covariance of x, y [m] and yaw [rad]."""
        return self.noise + self.bias


def tag_pose(
    camera: FixedCamera,
    mount: TagMount,
    corners_uv: NDArray[np.float64],
    corner_sigma: float = CORNER_SIGMA,
    common_sigma: float = COMMON_SIGMA,
) -> TagPose:
    """Fit x, y and yaw to the corners of a horizontal tag at a known height.

    All six degrees of freedom are not well determined for a tag parallel to the image: its pitch
    and roll flip between two similar solutions. Three are well determined.

    Args:
        camera: The camera.
        mount: Mount of the tag on the robot.
        corners_uv: (4, 2) [px] from `TagDetector`.
        corner_sigma: Independent standard deviation of each coordinate [px].
        common_sigma: Common standard deviation of the four corners [px].

    Raises:
        GeometryError: The rays do not meet the tag's plane, or do not span a square.
    """
    pose = _first(camera, mount, corners_uv)
    for _ in range(MAX_ITERATIONS):
        residual, J, _ = _linear(camera, mount, pose, corners_uv)
        step = np.linalg.lstsq(J, residual, rcond=None)[0]
        pose = PlanarPose(pose.x + step[0], pose.y + step[1], pose.yaw + step[2])
        if np.abs(step).max() < MIN_STEP:
            break
    residual, J, J_camera = _linear(camera, mount, pose, corners_uv)
    squared_residual = float(residual @ residual) / corner_sigma**2
    inverse = np.linalg.inv(J.T @ J)
    # Scale up the covariance of corners that fit worse than expected.
    noise = inverse * corner_sigma**2 * max(1.0, squared_residual / REDUNDANCY)
    lever = inverse @ J.T @ J_camera
    shift = inverse @ J.T @ np.tile(np.eye(2), (4, 1))
    bias = lever @ camera.covariance @ lever.T + common_sigma**2 * shift @ shift.T
    return TagPose(pose, _symmetric(noise), _symmetric(bias), squared_residual)


def _first(camera: FixedCamera, mount: TagMount, corners_uv: NDArray[np.float64]) -> PlanarPose:
    """The rigid motion of the square to the intersections of the rays with its plane."""
    found = camera.on_plane(corners_uv, mount.height)
    if not np.isfinite(found).all():
        raise GeometryError(
            f"camera '{camera.name}': the rays of a tag do not meet its plane at "
            f"{mount.height} m; check that the calibration belongs to the camera"
        )
    own = mount.corners_xy
    middle, target = own.mean(axis=0), found.mean(axis=0)
    a, b = own - middle, found - target
    along, across = float((a * b).sum()), float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
    if np.hypot(along, across) < 1e-3 * float((a * a).sum()):
        raise GeometryError(f"camera '{camera.name}': the corners of a tag span no square")
    turn = PlanarPose(0.0, 0.0, float(np.arctan2(across, along)))
    x, y = target - turn.applied(middle)
    return PlanarPose(x, y, turn.yaw)


def _linear(
    camera: FixedCamera, mount: TagMount, pose: PlanarPose, corners_uv: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Residuals (8,), their derivatives by x, y, yaw (8, 3) and by the extrinsics (8, 6).

    The residual is measured minus expected, so that both derivatives are those of the
    expectation.
    """
    own = mount.corners_xy
    ground = np.column_stack([pose.applied(own), np.full(len(own), mount.height)])
    seen = camera.seen_from_camera(ground)
    expected = camera.lens.project(seen)
    if not np.isfinite(expected).all():
        raise GeometryError(f"camera '{camera.name}': the pose of a tag ran out of the image")
    by_camera, by_pose = corner_slopes(camera, seen, ground[:, :2] - pose.xy)
    return (corners_uv - expected).ravel(), by_pose.reshape(-1, 3), by_camera.reshape(-1, 6)


def corner_slopes(
    camera: FixedCamera, seen_xyz: NDArray[np.float64], around_xy: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Derivatives of the image of points of a horizontal body.

    Args:
        camera: The camera.
        seen_xyz: (n, 3) points in its optical frame [m].
        around_xy: (n, 2) points in map relative to the body's centre of rotation [m].

    Returns:
        (n, 2, 6) [px/rad], [px/m] by the camera's pose (φ, ρ), and (n, 2, 3) by x, y [m] and yaw
        [rad] of the body.
    """
    slopes = camera.lens.projection_slopes(seen_xyz)
    moves = np.zeros((len(seen_xyz), 3, 3))
    moves[:, 0, 0] = moves[:, 1, 1] = 1
    moves[:, 0, 2], moves[:, 1, 2] = -around_xy[:, 1], around_xy[:, 0]
    # The point moves against the camera: p' = p - φ × p - ρ = p + [p]× φ - ρ.
    against = -np.tile(np.eye(3), (len(seen_xyz), 1, 1))
    by_camera = slopes @ np.concatenate([_cross(seen_xyz), against], axis=2)
    return by_camera, slopes @ camera.T_map_camera.rotation.inv().as_matrix() @ moves


def _cross(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3, 3) matrices [p]× of the cross product p ×."""
    x, y, z = points_xyz.T
    o = np.zeros_like(x)
    return np.stack([o, -z, y, z, o, -x, -y, x, o], axis=1).reshape(-1, 3, 3)


def _symmetric(matrix: NDArray[np.floating]) -> NDArray[np.float64]:
    return np.asarray((matrix + matrix.T) / 2, dtype=np.float64)
