"""Simple solids: a cube for cells, boxes for the robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CUBE_VERTICES = np.array(
    [[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)], np.float32
)
"""(8, 3) of a cube of side 1 about the origin."""
CUBE_FACES = np.array(
    [triangle
     for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2),
                        (1, 3, 7, 5))
     for triangle in ((a, b, c), (a, c, d))], np.uint32,
)  # fmt: skip
"""(12, 3) its triangles, seen from outside."""
HULL = (0.455, 0.381, 0.20)
"""Length, width and height of the Pioneer's hull [m]."""
MAST = 0.03
"""Width of the mast [m]."""

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def robot_boxes(camera_xyz: NDArray[np.floating]) -> list[Box]:
    """Hull, mast and camera as middles and sizes [m] in the robot's frame.

    Args:
        camera_xyz: (3,) [m] where the camera is mounted.
    """
    x, y, z = (float(value) for value in camera_xyz)
    top = max(z, 0.3)
    return [
        ((-0.045, 0.0, 0.05 + HULL[2] / 2), HULL),
        ((x, y, (0.25 + top) / 2), (MAST, MAST, top - 0.25)),
        ((x, y, z), (0.14, 0.05, 0.04)),
    ]
