"""Where a camera is at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import RigidTransform, Rotation


@dataclass(frozen=True)
class Station:
    """A place to take a frame from.

    Attributes:
        stamp: Time [s].
        T_map_camera: The camera's pose, optical frame.
    """

    stamp: float
    T_map_camera: RigidTransform


def looking_at(position_xyz: ArrayLike, target_xyz: ArrayLike) -> RigidTransform:
    """Pose of an upright camera: optical z towards the target, optical x level.

    Args:
        position_xyz: (3,) [m] where the camera is, map frame.
        target_xyz: (3,) [m] what it looks at; not straight above or below.

    Returns:
        `T_map_camera`.
    """
    position, target = np.asarray(position_xyz, float), np.asarray(target_xyz, float)
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = Rotation.from_matrix(np.column_stack([right, np.cross(forward, right), forward]))
    return RigidTransform.from_components(position, rotation)
