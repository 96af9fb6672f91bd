"""The floor under a robot: flat, whatever the noise says."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.registration import FLOOR
from circumspect.mapping.scan import Scan

UPRIGHT = 0.7
"""What is near z = 0 with a normal that points up by more than this is floor."""


def with_level_floor(
    scan: Scan, normals_xyz: NDArray[np.float64], T_map_camera: RigidTransform
) -> NDArray[np.float64]:
    """The normals of a scan, those of the floor exactly vertical.

    Depth that is quantised makes steps of a floor that lies far off. They move with the camera,
    and their slanted normals would hold it to where it was; a level floor says nothing of place
    and heading.

    Args:
        scan: Taken by a robot that stands on the floor at z = 0.
        normals_xyz: (n, 3) unit vectors, optical frame.
        T_map_camera: Where it was taken from.

    Returns:
        (n, 3).
    """
    matrix = T_map_camera.as_matrix()
    up = matrix[2, :3]
    heights = scan.points_xyz @ up + matrix[2, 3]
    floor = (np.abs(heights) < FLOOR) & (normals_xyz @ up > UPRIGHT)
    return np.where(floor[:, None], up, normals_xyz)
