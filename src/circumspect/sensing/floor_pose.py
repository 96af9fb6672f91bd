"""Where a camera in the hand is, by the floor that it sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.sensing.pixel_rays import pixel_rays
from circumspect.sensing.rgbd_frame import RgbdFrame

MAX_POINTS = 4000
TRIALS = 300
TOLERANCE = 0.015
"""Points of the floor are no further off it [m], at 1 m; further away in proportion."""
MIN_SHARE = 0.12
"""Of the points that lie on the floor."""
HEIGHTS = 0.3, 2.5
"""A camera in the hand is so far above the floor [m]."""
MAX_ROLL = np.radians(25)
TILTS = np.radians(5), np.radians(80)
"""So far down it looks."""
BELOW = 0.05
"""Points this far [m] below a plane are not under a floor; walls and tables have such."""
MAX_BELOW = 0.02
"""Share of points that may lie there: noise."""


def floor_pose(frame: RgbdFrame, seed: int = 0) -> RigidTransform | None:
    """The pose of the camera above the floor, looking along x from the map's z axis.

    The floor is the plane with most points that lies below the camera, with nearly nothing below.

    Args:
        frame: Its pose is not used.
        seed: Of the random planes that are tried.

    Returns:
        `T_map_camera` with the floor at z = 0 and the camera above the origin; None where no floor
        is seen.
    """
    points = _thinned(frame)
    if len(points) < 3:
        return None
    rng = np.random.default_rng(seed)
    tolerance = TOLERANCE * np.maximum(points[:, 2], 1.0)
    best, most = None, MIN_SHARE * len(points)
    for _ in range(TRIALS):
        plane = _plane(points[rng.choice(len(points), 3, replace=False)])
        if plane is None:
            continue
        above = points @ plane[:3] + plane[3]
        count = int((np.abs(above) < tolerance).sum())
        if count > most and (above < -BELOW).mean() < MAX_BELOW:
            best, most = plane, count
    if best is None:
        return None
    near = np.abs(points @ best[:3] + best[3]) < tolerance
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
    fits = HEIGHTS[0] <= height <= HEIGHTS[1] and TILTS[0] <= tilt <= TILTS[1]
    return np.append(normal, height) if fits and abs(roll) <= MAX_ROLL else None


def _above(plane: NDArray[np.float64]) -> RigidTransform:
    """The pose of a camera whose floor is known in its own frame."""
    z = plane[:3]
    x = np.array([0.0, 0.0, 1.0]) - z[2] * z
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(z, x), z])
    return RigidTransform.from_components([0.0, 0.0, plane[3]], Rotation.from_matrix(axes))
