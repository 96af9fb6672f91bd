"""Detection of the floor in a frame, check of its height, and pose of a camera above it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry.supporting_plane import largest_with_all_above
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.pixel_rays import pixel_rays
from circumspect.sensing.rgbd_frame import RgbdFrame

MIN_CHANGE = 1e-5
"""Change of slopes and height [m] at which the iteration ends."""
BAND_M = 0.06
"""Search distance around the expected floor [m]."""
MIN_POINTS = 200
"""Minimum number of points of a floor."""
SAMPLED_PIXELS = 8_500
"""Approximate number of sampled pixels."""
MAX_FRACTION_BELOW = 0.05
"""Maximum fraction of points below the floor."""
MAX_POINTS = 4000
TRIALS = 300
INLIER_TOLERANCE_M = 0.015
"""Maximum distance of inliers from the floor [m] at 1 m, in proportion to the distance."""
MIN_INLIER_FRACTION = 0.12
"""Minimum fraction of inliers."""
HEIGHT_RANGE_M = 0.3, 2.5
"""Range of the height of a hand-held camera above the floor [m]."""
MAX_ROLL_RAD = np.radians(25)
TILT_RANGE_RAD = np.radians(5), np.radians(80)
"""Range of its downward tilt [rad]."""
BELOW_MARGIN_M = 0.05
"""Distance below a plane beyond which points prove that it is not the floor [m]."""


class FloorProblem(StrEnum):
    """Contradictions to a floor at Z = 0 of the map."""

    NO_FLOOR = "no floor in view at Z = 0; are the camera's height and tilt right?"
    BELOW_FLOOR = "too much lies below the floor at Z = 0; are the camera's height and tilt right?"


def floor_problem(frame: RgbdFrame, noise: DepthNoise) -> FloorProblem | None:
    """Check the floor at Z = 0 of the map.

    A wrong mount makes the floor part of the object, or cuts off the feet of the object. Errors of
    0.3 m in height and of 5° in tilt are detected, 3° are not.

    Args:
        frame: A frame with a pose.
        noise: Depth noise of the camera, which defines its range.

    Returns:
        The contradiction, or None.

    Raises:
        InputError: The frame has no pose.
    """
    near = frame.valid & (frame.depth < noise.farthest)
    step = max(1, round(math.sqrt(near.size / SAMPLED_PIXELS)))
    heights = frame.sparse_points_map(step, near)[:, 2]
    if len(heights) < MIN_POINTS:
        return None
    if float((heights < -BAND_M).mean()) > MAX_FRACTION_BELOW:
        return FloorProblem.BELOW_FLOOR
    if np.count_nonzero(np.abs(heights) < BAND_M) < MIN_POINTS:
        return FloorProblem.NO_FLOOR
    return None


@dataclass(frozen=True)
class FloorPlane:
    """z = slope_x x + slope_y y + offset in the map frame.

    Attributes:
        slope_x, slope_y: Slope [m/m].
        offset: Height at the origin [m].
    """

    slope_x: float = 0.0
    slope_y: float = 0.0
    offset: float = 0.0

    def heights(self, points_xyz: NDArray[np.floating]) -> NDArray[np.floating]:
        """(n,) vertical distance of (n, 3) points above the floor [m]."""
        x, y, z = points_xyz[:, 0], points_xyz[:, 1], points_xyz[:, 2]
        return z - self.slope_x * x - self.slope_y * y - self.offset

    def refined(
        self,
        points_xyz: NDArray[np.floating],
        band: float = BAND_M,
        max_slope: float = 0.05,
        min_points: int = MIN_POINTS,
        max_iterations: int = 6,
    ) -> FloorPlane:
        """Fit the plane to nearby points by iteratively reweighted least squares.

        Tukey's weights, scaled with the median absolute residual, exclude objects on the floor.

        Args:
            points_xyz: (n, 3) points of the frame [m], map frame.
            band: Maximum distance of the used points from this plane [m].
            max_slope: Maximum difference of the slopes from this plane.
            min_points: Minimum number of points; with fewer the plane is returned unchanged.
            max_iterations: Maximum number of iterations.

        Returns:
            The fitted plane, or this one if the fit is not reliable.
        """
        near = points_xyz[np.abs(self.heights(points_xyz)) < band].astype(np.float64)
        if len(near) < min_points:
            return self
        centre = near[:, :2].mean(axis=0)
        design = np.column_stack([near[:, :2] - centre, np.ones(len(near))])
        z, weights = near[:, 2], np.ones(len(near))
        solution = np.full(3, np.inf)
        for _ in range(max_iterations):
            weighted = design * weights[:, None]
            before = solution
            solution = np.linalg.lstsq(weighted.T @ design, weighted.T @ z, rcond=None)[0]
            if np.abs(solution - before).max() < MIN_CHANGE:
                break
            residual = z - design @ solution
            spread = max(1.4826 * float(np.median(np.abs(residual))), 5e-4)
            weights = np.clip(1 - (residual / (4.685 * spread)) ** 2, 0, None) ** 2
        slope_x, slope_y, level = (float(value) for value in solution)
        fitted = FloorPlane(slope_x, slope_y, level - float(solution[:2] @ centre))
        change = np.hypot(slope_x - self.slope_x, slope_y - self.slope_y)
        moved = abs(fitted.offset - self.offset + (solution[:2] - self._slopes) @ centre)
        return fitted if change < max_slope and moved < band else self

    @property
    def _slopes(self) -> NDArray[np.float64]:
        return np.array([self.slope_x, self.slope_y])


def floor_pose(frame: RgbdFrame, seed: int = 0) -> RigidTransform | None:
    """Estimate the pose of the camera above the floor, looking along x from the map's z axis.

    The floor is the plane below the camera with the most points and almost none below it.

    Args:
        frame: The frame; its pose is not used.
        seed: Seed of the random planes.

    Returns:
        `T_map_camera` with the floor at z = 0 and the camera above the origin; None without a
        floor.
    """
    points = _thinned(frame)
    if len(points) < 3:
        return None
    rng = np.random.default_rng(seed)
    tolerance = INLIER_TOLERANCE_M * np.maximum(points[:, 2], 1.0)
    tried = [_plane(points[rng.choice(len(points), 3, replace=False)]) for _ in range(TRIALS)]
    if not (planes := [plane for plane in tried if plane is not None]):
        return None
    normals, heights = np.stack(planes)[:, :3], np.stack(planes)[:, 3]
    best = largest_with_all_above(
        points, normals, -heights, tolerance, BELOW_MARGIN_M, MIN_INLIER_FRACTION * len(points)
    )
    if best is None:
        return None
    near = np.abs(points @ normals[best] + heights[best]) < tolerance
    refined = _plane(points[near])
    return None if refined is None else _above(refined)


def _thinned(frame: RgbdFrame) -> NDArray[np.float64]:
    """(n, 3) [m] in the optical frame."""
    rows, columns = np.nonzero(frame.valid)
    step = max(1, len(rows) // MAX_POINTS)
    rows, columns = rows[::step], columns[::step]
    rays = pixel_rays(frame.camera)[rows, columns]
    return (rays * frame.depth[rows, columns][:, None]).astype(np.float64)


def _plane(points: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """(4,) normal towards the camera and height of the camera; None where it can be no floor."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][-1]
    height = -float(normal @ middle)
    if height < 0:
        normal, height = -normal, -height
    tilt, roll = np.arctan2(-normal[2], -normal[1]), np.arcsin(np.clip(normal[0], -1, 1))
    fits = (
        HEIGHT_RANGE_M[0] <= height <= HEIGHT_RANGE_M[1]
        and TILT_RANGE_RAD[0] <= tilt <= TILT_RANGE_RAD[1]
    )
    return np.append(normal, height) if fits and abs(roll) <= MAX_ROLL_RAD else None


def _above(plane: NDArray[np.float64]) -> RigidTransform:
    """The pose of a camera whose floor is known in its own frame."""
    z = plane[:3]
    x = np.array([0.0, 0.0, 1.0]) - z[2] * z
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(z, x), z])
    return RigidTransform.from_components([0.0, 0.0, plane[3]], Rotation.from_matrix(axes))
