"""How a map begins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import SHORT, blind, follow, place_errors, short_drive, true_camera

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.mapping import GATE_OPEN, RegisteredPoses


def test_frames_that_begin_no_map_are_not_told_as_sure() -> None:
    frames = short_drive()
    told = follow([*map(blind, frames[:3]), *frames[3:]])
    assert [estimate.certain for estimate in told[:4]] == [False, False, False, True]
    assert [estimate.converged for estimate in told[:4]] == [False, False, False, True]
    assert {"0 points in range"} == {estimate.gate for estimate in told[:3]}
    assert {GATE_OPEN} == {estimate.gate for estimate in told[3:]}


def test_a_first_pose_that_was_given_goes_on_with_the_wheels_until_there_is_a_map() -> None:
    frames, first = short_drive(), true_camera(float(SHORT[0]))
    told = follow([*map(blind, frames[:6]), *frames[6:]], RegisteredPoses(first))
    errors = place_errors(told, SHORT)
    # The wheels claim 4 % more than the truth.
    way = np.linalg.norm(true_camera(float(SHORT[6])).translation - first.translation)
    assert errors[6] < 0.05 * way
    assert errors[6:].max() < 0.03


def test_frames_that_are_passed_over_move_a_first_pose_on_as_well() -> None:
    frames, first = short_drive(), true_camera(float(SHORT[0]))
    poses = RegisteredPoses(first)
    for frame in frames[:6]:
        poses.pass_over(frame)
    way = np.linalg.norm(true_camera(float(SHORT[6])).translation - first.translation)
    told = poses.estimate(frames[6])
    off = told.T_map_camera.translation - true_camera(float(SHORT[6])).translation
    assert np.linalg.norm(off) < 0.05 * way


def test_a_first_pose_goes_on_over_a_frame_of_which_the_wheels_said_nothing() -> None:
    frames, first = short_drive(), true_camera(float(SHORT[0]))
    early = [*map(blind, frames[:6])]
    early[3] = replace(early[3], odometry=None)
    told = follow([*early, *frames[6:8]], RegisteredPoses(first))
    way = np.linalg.norm(true_camera(float(SHORT[6])).translation - first.translation)
    assert place_errors(told, SHORT[:8])[6] < 0.05 * way


@pytest.mark.parametrize("east", [5e5, -3e6])
def test_odometry_that_begins_far_away_is_refused_with_the_remedy(east: float) -> None:
    frame = short_drive()[0]
    far = replace(frame.odometry, T_odom_base=PlanarPose(east, 5.4e6, 0.3))
    with pytest.raises(InputError, match=r"5400 km from the origin; take the place of the first"):
        RegisteredPoses().estimate(replace(frame, odometry=far))


@pytest.mark.parametrize("wheels", [True, False])
def test_a_clock_that_leaps_by_decades_is_survived(wheels: bool) -> None:
    frames = [
        replace(
            frame,
            stamp=frame.stamp + (1.7e9 if number > 4 else 0.0),
            odometry=replace(frame.odometry, stamp=frame.odometry.stamp) if wheels else None,
        )
        for number, frame in enumerate(short_drive()[:8])
    ]
    told = follow(frames)
    assert all(np.isfinite(estimate.T_map_camera.as_matrix()).all() for estimate in told)
    assert all(np.linalg.eigvalsh(estimate.covariance)[0] > 0 for estimate in told)


def test_wheels_whose_covariance_is_no_number_are_worth_nothing_and_do_no_harm() -> None:
    frames = [
        replace(frame, odometry=replace(frame.odometry, covariance=np.eye(3) * 1e300 * (n > 0)))
        for n, frame in enumerate(short_drive()[:6])
    ]
    told = follow(frames)
    assert place_errors(told, SHORT[:6]).max() < 0.03


def test_a_camera_on_a_head_that_pans_is_followed() -> None:
    """The robot stands; its head turns by 3° a frame, as TF tells."""
    frame = short_drive()[0]
    turned = [RigidTransform.from_rotation(_about_z(3.0 * n)) for n in range(6)]
    mounts = [turn * frame.T_base_camera for turn in turned]
    poses = RegisteredPoses()
    poses.estimate(frame)
    for number, mount in enumerate(mounts[1:], 1):
        # Nothing in sight: the wheels alone say where the camera looks.
        seen = replace(blind(frame), stamp=float(number), T_base_camera=mount)
        seen = replace(seen, odometry=replace(frame.odometry, stamp=float(number)))
        told = poses.estimate(seen)
        away = (mount.inv() * told.T_map_base.as_transform().inv() * told.T_map_camera).as_matrix()
        assert np.abs(away - np.eye(4)).max() < 1e-9
        assert np.hypot(told.T_map_base.x, told.T_map_base.y) < 1e-3
        assert abs(told.T_map_base.yaw) < np.radians(0.1)


def _about_z(degrees: float):
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("z", degrees, degrees=True)
