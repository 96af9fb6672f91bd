from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.mapping import GATE_OPEN, KnownPoses, PoseEstimate
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


def test_a_pose_that_is_taken_as_true_is_sure() -> None:
    estimate = PoseEstimate(RigidTransform.identity())
    assert estimate.deviations is None
    assert estimate.sure


@pytest.mark.parametrize(
    ("turn", "place", "certain", "sure"),
    [
        (0.017, 0.016, True, True),
        (0.017, 0.016, False, False),
        (0.018, 0.001, True, False),
        (0.001, 0.017, True, False),
    ],
)
def test_a_certain_pose_is_sure_only_where_its_whole_covariance_is_small(
    turn: float, place: float, certain: bool, sure: bool
) -> None:
    turned = np.zeros((6, 6))
    for block, largest in ((slice(0, 3), turn), (slice(3, 6), place)):
        axes = Rotation.from_euler("xyz", [0.3, 0.5, 0.7]).as_matrix()
        turned[block, block] = axes @ np.diag([largest, 1e-4, 1e-5]) ** 2 @ axes.T
    estimate = PoseEstimate(
        RigidTransform.identity(), covariance=turned, doubt="" if certain else "lost"
    )
    assert estimate.deviations == pytest.approx((turn, place))
    assert estimate.sure is sure
