from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.mapping import GATE_OPEN, KnownPoses
from circumspect.sensing import RgbdFrame

CAMERA = PinholeCamera(8, 6, 10.0, 11.0, 3.5, 2.5)


def test_known_poses_are_taken_as_they_are() -> None:
    pose = RigidTransform.from_translation([1.0, 2.0, 3.0])
    frame = RgbdFrame(np.ones((6, 8)), CAMERA, 0.0, pose)
    estimate = KnownPoses().estimate(frame)
    assert estimate.T_map_camera is frame.T_map_camera
    assert (estimate.converged, estimate.inliers, estimate.residual) == (True, 48, 0.0)
    assert estimate.gate == GATE_OPEN


def test_a_frame_without_a_pose_is_told() -> None:
    with pytest.raises(InputError, match="no pose"):
        KnownPoses().estimate(RgbdFrame(np.ones((6, 8)), CAMERA, 0.0))
