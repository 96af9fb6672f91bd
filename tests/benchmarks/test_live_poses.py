"""Errors of poses that are flagged reliable or accurate."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.live_poses import reliability_figures
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import Trajectory
from circumspect.tracking import PoseEstimate, TrackingState

STAMPS = np.arange(4.0)
ROUND = Rotation.from_euler("z", 70, degrees=True)
SIGMAS = np.array([0.01, 0.01, 0.01, 0.01, 0.02, 0.03])


def pose(
    x: float, shift: tuple[float, float, float], state: TrackingState = TrackingState.TRACKING
) -> PoseEstimate:
    """A camera turned by 70°, whose estimate is off by `shift` [m] in the camera's axes."""
    T_map_camera = RigidTransform.from_components([x, 0, 0], ROUND)
    off = RigidTransform.from_translation(list(shift))
    return PoseEstimate(T_map_camera * off, covariance=np.diag(SIGMAS**2), state=state)


def judged(*poses: PoseEstimate):
    truth = [RigidTransform.from_components([x, 0, 0], ROUND) for x in STAMPS]
    estimates = list(zip(STAMPS.tolist(), poses, strict=False))
    return reliability_figures(estimates, Trajectory(STAMPS, RigidTransform.concatenate(truth)))


def test_errors_are_in_metres_and_in_estimated_standard_deviations() -> None:
    none = (0.0, 0.0, 0.0)
    found = judged(pose(0, none), pose(1, (0, 0.05, 0)), pose(2, (0, 0, 0.06)), pose(3, none))
    assert found.worst_reliable_m == pytest.approx(0.06)
    assert found.worst_reliable_sigmas == pytest.approx(2.5)
    assert found.reliable == 1
    assert found.nees_median == pytest.approx((0 + 2**2) / 2)


def test_unreliable_poses_and_small_errors_do_not_count() -> None:
    none = (0.0, 0.0, 0.0)
    some = pose(1, (0.009, 0, 0)), pose(2, (0, 0.5, 0), state=TrackingState.LOST)
    found = judged(pose(0, none), *some, pose(3, none))
    assert found.worst_reliable_m == pytest.approx(0.009)
    assert found.worst_reliable_sigmas is None
    assert found.reliable == 0.75


def test_a_reliable_pose_with_a_large_covariance_is_not_accurate() -> None:
    # A standard deviation of 30 mm: reliable in its map, accurate nowhere.
    none = (0.0, 0.0, 0.0)
    vague = judged(pose(0, none), pose(1, (0, 0.05, 0)))
    assert (vague.worst_accurate_m, vague.accurate) == (None, 0.0)
    taken = [PoseEstimate(p.T_map_camera) for p in (pose(0, none), pose(1, (0, 0.05, 0)))]
    believed = judged(*taken)
    assert believed.worst_accurate_m == pytest.approx(0.05)
    assert believed.accurate == 1
