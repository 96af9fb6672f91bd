"""Whether a frame shows the floor where it is said to be."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_plane import BAND, FEWEST
from circumspect.sensing.rgbd_frame import RgbdFrame

LOOKED_AT = 8_500
"""About so many pixels are, spread over the image."""
MOST_BELOW = 0.05
"""Share of the points that may lie below the floor."""


class FloorFault(StrEnum):
    """What contradicts a floor at Z = 0 of the map."""

    NO_FLOOR = "no floor in view at Z = 0; are the camera's height and tilt right?"
    BELOW_FLOOR = "too much lies below the floor at Z = 0; are the camera's height and tilt right?"


def floor_fault(frame: RgbdFrame, noise: DepthNoise) -> FloorFault | None:
    """What speaks against a floor at Z = 0 of the map; None where nothing does.

    A camera that is mounted otherwise than it is said to be makes the floor itself an object, or
    cuts an object's feet off: 0.3 m in height and 5° of tilt are found, 3° are not.

    Args:
        frame: A frame with a pose.
        noise: The camera's; tells its range.

    Returns:
        The contradiction, or None.

    Raises:
        InputError: The frame has no pose.
    """
    near = frame.valid & (frame.depth < noise.farthest)
    step = max(1, round(math.sqrt(near.size / LOOKED_AT)))
    heights = frame.sparse_points_map(step, near)[:, 2]
    if len(heights) < FEWEST:
        return None
    if float((heights < -BAND).mean()) > MOST_BELOW:
        return FloorFault.BELOW_FLOOR
    if np.count_nonzero(np.abs(heights) < BAND) < FEWEST:
        return FloorFault.NO_FLOOR
    return None
