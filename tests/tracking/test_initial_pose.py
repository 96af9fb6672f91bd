"""How a map starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation
from tracking_world import SETTINGS, SHORT, blind, follow, place_errors, short_drive, true_camera

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.tracking import Tracker, TrackingState


def test_frames_that_do_not_start_a_map_are_not_reliable() -> None:
    frames = short_drive()
    tracked = follow([*map(blind, frames[:3]), *frames[3:]])
    assert [estimate.reliable for estimate in tracked[:4]] == [False, False, False, True]
    assert {estimate.state for estimate in tracked[:3]} == {TrackingState.INITIALISING}
    assert {estimate.reason for estimate in tracked[:3]} == {"no map yet: 0 points in range"}
    assert {estimate.state for estimate in tracked[3:]} == {TrackingState.TRACKING}
    assert {estimate.reason for estimate in tracked[3:]} == {""}


def test_odometry_moves_a_given_first_pose_until_there_is_a_map() -> None:
    frames, first = short_drive(), true_camera(float(SHORT[0]))
    tracked = follow([*map(blind, frames[:6]), *frames[6:]], Tracker(first, SETTINGS))
    errors = place_errors(tracked, SHORT)
    # The odometry claims 4 % more than the truth.
    distance = np.linalg.norm(true_camera(float(SHORT[6])).translation - first.translation)
    assert errors[6] < 0.05 * distance
    assert errors[6:].max() < 0.03


def test_skipped_frames_move_a_given_first_pose_as_well() -> None:
    frames, first = short_drive(), true_camera(float(SHORT[0]))
    tracker = Tracker(first, SETTINGS)
    for frame in frames[:6]:
        tracker.skip(frame)
    distance = np.linalg.norm(true_camera(float(SHORT[6])).translation - first.translation)
    tracked = tracker.track(frames[6])
    off = tracked.T_map_camera.translation - true_camera(float(SHORT[6])).translation
    assert np.linalg.norm(off) < 0.05 * distance


def test_a_given_first_pose_is_moved_over_a_frame_without_odometry() -> None:
    frames, first = short_drive(), true_camera(float(SHORT[0]))
    early = [*map(blind, frames[:6])]
    early[3] = replace(early[3], odometry=None)
    tracked = follow([*early, *frames[6:8]], Tracker(first, SETTINGS))
    distance = np.linalg.norm(true_camera(float(SHORT[6])).translation - first.translation)
    assert place_errors(tracked, SHORT[:8])[6] < 0.05 * distance


@pytest.mark.parametrize("east", [5e5, -3e6])
def test_odometry_that_starts_far_away_is_refused_with_the_remedy(east: float) -> None:
    frame = short_drive()[0]
    far = replace(frame.odometry, T_odom_base=PlanarPose(east, 5.4e6, 0.3))
    with pytest.raises(InputError, match="5400 km from the origin; subtract the position"):
        Tracker(settings=SETTINGS).track(replace(frame, odometry=far))


def test_a_camera_on_a_panning_head_is_tracked() -> None:
    """The robot stands; its head turns by 3° a frame."""
    frame = short_drive()[0]
    turned = [
        RigidTransform.from_rotation(Rotation.from_euler("z", 3.0 * n, degrees=True))
        for n in range(6)
    ]
    mounts = [turn * frame.T_base_camera for turn in turned]
    tracker = Tracker(settings=SETTINGS)
    tracker.track(frame)
    for number, mount in enumerate(mounts[1:], 1):
        # Nothing is in sight: odometry and mount alone say where the camera looks.
        shot = replace(blind(frame), stamp=float(number), T_base_camera=mount)
        shot = replace(shot, odometry=replace(frame.odometry, stamp=float(number)))
        base = tracker.track(shot).T_map_base
        assert np.hypot(base.x, base.y) < 1e-3
        assert abs(base.yaw) < np.radians(0.1)
