"""Whether a fit that leapt far from where the camera was expected is to be believed."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.pose_distance import distances
from circumspect.mapping.motion import Belief
from circumspect.registration import Registration, RegistrationSettings, Scan, SurfaceMap, register

FAR = 2.0
"""A fit that moves a frame by more than so many reaches of correspondences leaps."""
BETTER = 0.9
"""At this share of the mean distance to the map a frame fits clearly better."""
LEAST_DISTANCE = 5e-4
"""Below this [m] one distance to the map is as good as another."""


def is_hasty(
    scan: Scan,
    scene: SurfaceMap,
    found: Registration,
    expected: Belief,
    usual: float,
    settings: RegistrationSettings,
) -> bool:
    """Whether a frame leapt to where it fits worse than others did, or no better than at home.

    Where little is known of the pose, a frame of a flat side slides along it until it meets the
    first edge, and that edge need not be the right one.

    Args:
        scan: The frame's points.
        scene: What they were fitted to.
        found: The fit.
        expected: Where the camera was expected.
        usual: Mean distance to the map [m] up to which a frame fits as the last ones did.
        settings: How frames are fitted.
    """
    if _apart(found.T_map_camera, expected.T_map_camera) < FAR * settings.max_distance:
        return False
    if found.distance > usual:
        return True
    held = np.eye(6) / settings.max_distance**2
    stayed = register(scan, scene, expected.T_map_camera, held, settings)
    if _apart(stayed.T_map_camera, found.T_map_camera) < settings.max_distance:
        return False  # the scene pulls it there all the same
    return bool(BETTER * stayed.distance < found.distance)


def _apart(one: RigidTransform, other: RigidTransform) -> float:
    """Distance of two places [m]."""
    return float(distances(one.as_matrix(), other.as_matrix())[0])
