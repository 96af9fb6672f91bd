"""Whether `--first-pose` can be where the camera was."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.cli.say import say
from circumspect.errors import InputError
from circumspect.sensing import DepthNoise, RgbdFrame

HIGHEST = 10.0
"""Of a camera above the floor [m]; what is given beyond is in millimetres."""
BAND = 0.06
"""So far from Z = 0 the floor is looked for [m]; see `FloorPlane.refined`."""
FEWEST = 200
"""Points that make a floor, of one pixel in each block of `STEP`."""
STEP = 6
MOST_BELOW = 0.05
"""Share of the points that may lie below the floor."""


def require_above_floor(z: float) -> None:
    """A camera that stands on the floor's upper side.

    Args:
        z: Its height above the floor [m].

    Raises:
        InputError: It does not.
    """
    if not 0 < z <= HIGHEST:
        raise InputError(
            f"--first-pose: a camera {z:g} m above the floor; give Z in metres, above 0 and at "
            f"most {HIGHEST:g}, or the object's --box"
        )


def with_floor_checked(
    frames: Iterable[RgbdFrame], T_map_first: RigidTransform
) -> Iterator[RgbdFrame]:
    """The same frames; it is told where the first one has no floor at Z = 0.

    What is taken for an object that stands on the floor is then something else: a tilt that is
    5° off lifts the floor itself to where objects are.

    Args:
        frames: As they were recorded.
        T_map_first: Pose of the first of them.
    """
    for index, frame in enumerate(frames):
        if index == 0 and (fault := floor_fault(frame, T_map_first)) is not None:
            say(f"{fault}; check --first-pose, its Z and TILT above all")
        yield frame


def floor_fault(frame: RgbdFrame, T_map_camera: RigidTransform) -> str | None:
    """What speaks against a floor at Z = 0 in the frame; None where nothing does.

    Args:
        frame: With or without a pose of its own.
        T_map_camera: Where its camera is said to have been.
    """
    near = frame.valid & (frame.depth < DepthNoise().farthest)
    heights = frame.at(T_map_camera).sparse_points_map(STEP, near)[:, 2]
    if len(heights) < FEWEST:
        return None
    below = float((heights < -BAND).mean())
    if below > MOST_BELOW:
        return f"{below:.0%} of the first frame's points lie below the floor at Z = 0"
    if np.count_nonzero(np.abs(heights) < BAND) < FEWEST:
        return "the first frame shows no floor at Z = 0"
    return None
