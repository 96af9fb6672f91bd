"""Whether what a frame shows beyond the map is new, or out of place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.keyframes import Keyframes
from circumspect.registration import Registration, Scan, SurfaceMap
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M

SAMPLE = 1000
"""So many points of a frame are asked."""
MOST_CONTRARY, FEW = 0.2, 10
"""For each that lies on what is known, and then some, so many may lie where it was empty."""


def rest_is_news(
    scan: Scan,
    found: Registration,
    scene: SurfaceMap,
    keyframes: Keyframes,
    reach: float,
    contrary: float = MOST_CONTRARY,
) -> bool:
    """Whether what does not lie on what is known lies where nobody looked so far.

    A robot that turns a corner sees a lot that is new at once. One that is not where it believes
    to be puts things where there was nothing before.

    Args:
        scan: The frame's points.
        found: Where they are believed to lie.
        scene: What is known.
        keyframes: Whose free space is asked.
        reach: Points this near to the map [m] lie on what is known.
        contrary: For each that does, and then some, so many may lie where it was empty.
    """
    known, empty = _known_and_empty(scan, found.T_map_camera, scene, keyframes, reach)
    return int(empty.sum()) <= contrary * int(known.sum()) + FEW


def is_out_of_place(
    scan: Scan, T_map_camera: RigidTransform, scene: SurfaceMap, keyframes: Keyframes, reach: float
) -> bool:
    """Whether a frame shows much where it was known to be empty: the robot can not be there.

    A frame that shows nothing, or what nobody looked at so far, says nothing against its place.

    Args:
        scan: The frame's points.
        T_map_camera: Where the frame would have been taken.
        scene: What is known.
        keyframes: Whose free space is asked.
        reach: Points this near to the map [m] lie on what is known.
    """
    known, empty = _known_and_empty(scan, T_map_camera, scene, keyframes, reach)
    return int(empty.sum()) > MOST_CONTRARY * len(known) + FEW


def _known_and_empty(
    scan: Scan, T_map_camera: RigidTransform, scene: SurfaceMap, keyframes: Keyframes, reach: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Of some points off the floor: which lie on what is known, and of the others which lie where
    a keyframe looked through.
    """
    some = scan.subsampled(max(1, len(scan) // SAMPLE))
    points = T_map_camera.apply(some.points_xyz)
    points = points[np.abs(points[:, 2]) > MAX_FLOOR_HEIGHT_M]
    if len(points) == 0:
        return np.zeros(0, bool), np.zeros(0, bool)
    known = scene.nearest(points)[1] < reach
    return known, keyframes.seen_empty(points[~known])
