"""Pose estimates, and poses that are taken as true."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import RgbdFrame
from circumspect.tracking import KnownPoses, PoseEstimate, TrackingState

CAMERA = PinholeCamera(8, 6, 10.0, 11.0, 3.5, 2.5)
TRACKING = TrackingState.TRACKING


def test_known_poses_are_returned_unchanged() -> None:
    pose = RigidTransform.from_translation([1.0, 2.0, 3.0])
    frame = RgbdFrame(np.ones((6, 8)), CAMERA, 0.0, pose)
    estimate = KnownPoses().track(frame)
    assert estimate.T_map_camera is frame.T_map_camera
    assert (estimate.converged, estimate.inliers, estimate.residual) == (True, 48, 0.0)
    assert (estimate.state, estimate.reason, estimate.source) == (TRACKING, "", "given")
    assert estimate.reliable


def test_a_frame_without_a_pose_is_refused() -> None:
    with pytest.raises(InputError, match="no pose"):
        KnownPoses().track(RgbdFrame(np.ones((6, 8)), CAMERA, 0.0))


def test_a_pose_that_is_taken_as_true_is_accurate() -> None:
    estimate = PoseEstimate(RigidTransform.identity())
    assert estimate.sigmas is None
    assert estimate.accurate


@pytest.mark.parametrize(
    ("state", "reliable", "lost"),
    [
        (TrackingState.INITIALISING, False, False),
        (TRACKING, True, False),
        (TrackingState.DEAD_RECKONING, False, False),
        (TrackingState.LOST, False, True),
    ],
)
def test_only_a_tracked_pose_is_reliable(state: TrackingState, reliable: bool, lost: bool) -> None:
    estimate = PoseEstimate(RigidTransform.identity(), state)
    assert (estimate.reliable, estimate.accurate, estimate.lost) == (reliable, reliable, lost)


@pytest.mark.parametrize(
    ("rotation", "translation", "state", "accurate"),
    [
        (0.017, 0.016, TRACKING, True),
        (0.017, 0.016, TrackingState.DEAD_RECKONING, False),
        (0.018, 0.001, TRACKING, False),
        (0.001, 0.017, TRACKING, False),
    ],
)
def test_a_reliable_pose_is_accurate_only_if_its_whole_covariance_is_small(
    rotation: float, translation: float, state: TrackingState, accurate: bool
) -> None:
    covariance = np.zeros((6, 6))
    for block, largest in ((slice(0, 3), rotation), (slice(3, 6), translation)):
        axes = Rotation.from_euler("xyz", [0.3, 0.5, 0.7]).as_matrix()
        covariance[block, block] = axes @ np.diag([largest, 1e-4, 1e-5]) ** 2 @ axes.T
    estimate = PoseEstimate(RigidTransform.identity(), state, covariance=covariance)
    assert estimate.sigmas == pytest.approx((rotation, translation))
    assert estimate.accurate is accurate
