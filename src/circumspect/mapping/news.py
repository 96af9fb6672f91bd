"""Whether what a frame shows beyond the map is new, or out of place."""

from __future__ import annotations

import numpy as np

from circumspect.mapping.keyframes import Keyframes
from circumspect.mapping.registration import Registration
from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import FLOOR
from circumspect.mapping.scene_map import SceneMap

SAMPLE = 1000
"""So many points of a frame are asked."""
MOST_CONTRARY, FEW = 0.2, 10
"""For each that lies on what is known, and then some, so many may lie where it was empty."""


def rest_is_news(
    scan: Scan, found: Registration, scene: SceneMap, keyframes: Keyframes, reach: float
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
    """
    some = scan.thinned(max(1, len(scan) // SAMPLE))
    points = found.T_map_camera.apply(some.points_xyz)
    points = points[np.abs(points[:, 2]) > FLOOR]
    known = scene.nearest(points)[1] < reach
    empty = keyframes.seen_empty(points[~known])
    return int(empty.sum()) <= MOST_CONTRARY * int(known.sum()) + FEW
