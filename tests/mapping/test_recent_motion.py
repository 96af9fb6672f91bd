from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import blind, drive, follow, place_errors, short_drive, true_camera

from circumspect.geometry import se3
from circumspect.mapping import RegisteredPoses
from circumspect.mapping.motion import Belief, MotionSettings
from circumspect.mapping.predictions import Predictions
from circumspect.mapping.recent_motion import MOST_SHARE, RecentMotion

STEP = np.array([0.0, 0.02, 0.0, 0.05, 0.0, 0.01])


def watched(steps: list[tuple[float, float]]) -> RecentMotion:
    """After steps: shares of `STEP`, and times [s]."""
    recent = RecentMotion(MotionSettings())
    for share, time in steps:
        recent.add(se3.exp(share * STEP), time)
    return recent


def gone_on(recent: RecentMotion, time: float) -> np.ndarray:
    return se3.log(recent.going_on(time))


@pytest.mark.parametrize("time", [0.05, 0.1, 0.2])
def test_of_a_steady_stream_only_the_last_step_counts(time: float) -> None:
    recent = watched([(7.0, 0.1), (1.0, 0.1)])
    np.testing.assert_array_equal(
        recent.going_on(time).as_matrix(),
        se3.exp(time / 0.1 * se3.log(se3.exp(STEP))).as_matrix(),
    )


@pytest.mark.parametrize("gap", [0.02, 1e-3, 1e-6, 0.0])
def test_a_frame_stamped_late_does_not_change_the_velocity(gap: float) -> None:
    recent = watched([(1.0, 0.1), (1.0, 0.2 - gap), (1.0, gap)])
    np.testing.assert_allclose(gone_on(recent, 0.1), STEP, rtol=1e-9)


@pytest.mark.parametrize("time", [0.01, 0.1, 1.0, 1e3])
@pytest.mark.parametrize("gap", [0.01, 1e-5])
def test_a_motion_goes_on_no_longer_than_a_few_times_what_was_watched(
    gap: float, time: float
) -> None:
    moved = gone_on(watched([(1.0, gap)]), time)
    assert np.linalg.norm(moved) <= MOST_SHARE * np.linalg.norm(STEP) + 1e-12


@pytest.mark.parametrize("steps", [[], [(1.0, 0.0)]])
def test_who_was_not_watched_stands_still(steps: list[tuple[float, float]]) -> None:
    np.testing.assert_array_equal(gone_on(watched(steps), 0.1), np.zeros(6))


def test_a_forgotten_motion_stands_still() -> None:
    recent = watched([(1.0, 0.1)] * 3)
    recent.forget()
    np.testing.assert_array_equal(gone_on(recent, 0.1), np.zeros(6))


def test_steps_that_nothing_can_ask_for_are_not_kept() -> None:
    recent = watched([(1.0, 0.1)] * 500)
    assert len(recent._steps) < 10
    np.testing.assert_allclose(gone_on(recent, 1.5), 15 * STEP, rtol=1e-9)


def stamped(angles: np.ndarray, stamps: list[float]) -> list:
    """A drive without odometry."""
    frames = zip(drive(angles), stamps, strict=True)
    return [replace(frame, stamp=stamp, odometry=None) for frame, stamp in frames]


@pytest.mark.parametrize("gap", [1e-3, 1e-4])
def test_a_camera_that_stands_in_pairs_of_frames_is_not_driven_off(gap: float) -> None:
    angles = np.full(16, np.radians(60.0))
    stamps = [number // 2 * 0.1 + number % 2 * gap for number in range(len(angles))]
    told = follow(stamped(angles, stamps), RegisteredPoses(true_camera(float(angles[0]))))
    assert all(estimate.certain for estimate in told)
    assert place_errors(told, angles).max() < 0.006


@pytest.mark.parametrize("gap", [2e-3, 1e-4])
def test_a_frame_stamped_when_it_came_does_not_lose_a_camera_that_moves(gap: float) -> None:
    angles = np.radians(np.arange(60.0, 70.0, 0.5))
    stamps = [number * 0.1 for number in range(len(angles))]
    stamps[12] = stamps[13] - gap
    told = follow(stamped(angles, stamps), RegisteredPoses(true_camera(float(angles[0]))))
    assert all(estimate.certain for estimate in told)
    assert place_errors(told, angles).max() < 0.015


def test_a_lost_camera_does_not_drive_on() -> None:
    angles = np.radians(np.arange(60.0, 66.0, 0.5))
    frames = stamped(angles, [number * 0.1 for number in range(len(angles))])
    poses = RegisteredPoses(true_camera(float(angles[0])))
    follow(frames, poses)
    # The sensor is dead and shows a wall before the lens.
    wall = np.full_like(frames[-1].depth, 0.6)
    dead = [replace(frames[-1], depth=wall, stamp=2.0 + number * 0.1) for number in range(30)]
    before = poses.estimate(replace(blind(frames[-1]), stamp=1.9)).T_map_camera
    told = follow(dead, poses)
    assert told[-1].gate.startswith("lost")
    off: RigidTransform = before.inv() * told[-1].T_map_camera
    assert np.linalg.norm(off.translation) < 0.1


@pytest.mark.parametrize("rate", [2, 30, 100])
def test_a_fast_camera_that_nothing_holds_is_no_surer_than_a_slow_one(rate: int) -> None:
    settings, first = MotionSettings(), short_drive()[0]
    frame = replace(first, odometry=None, T_base_camera=None)
    belief = Belief(RigidTransform.identity(), np.zeros((6, 6)))
    expected = Predictions(settings)
    expected.passed(1 / rate, held=True)
    for _ in range(rate):
        belief = expected.by_steady_motion(belief, frame, 1 / rate)
        expected.passed(1 / rate, held=False)
    turn, place = belief.sigmas
    assert place == pytest.approx(settings.speed)
    assert turn == pytest.approx(settings.spin)
    expected.passed(1 / rate, held=True)
    again = expected.by_standing_still(Belief(belief.T_map_camera, np.zeros((6, 6))), frame, 0.1)
    assert again.sigmas[1] == pytest.approx(0.1 * settings.speed)
