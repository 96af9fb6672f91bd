"""Camera poses with a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import RigidTransform, Rotation


@dataclass(frozen=True)
class Station:
    """A camera pose at which a frame is taken.

    Attributes:
        stamp: Time [s].
        T_map_camera: Pose of the camera, optical frame.
    """

    stamp: float
    T_map_camera: RigidTransform


def looking_at(position_xyz: ArrayLike, target_xyz: ArrayLike) -> RigidTransform:
    """Pose of an upright camera: optical z towards the target, optical x level.

    Args:
        position_xyz: (3,) [m] position of the camera, map frame.
        target_xyz: (3,) [m] the target; not straight above or below.

    Returns:
        `T_map_camera`.
    """
    position, target = np.asarray(position_xyz, float), np.asarray(target_xyz, float)
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = Rotation.from_matrix(np.column_stack([right, np.cross(forward, right), forward]))
    return RigidTransform.from_components(position, rotation)
