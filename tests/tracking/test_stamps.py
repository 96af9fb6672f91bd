"""Stamps that do not keep pace with the camera, and broken odometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import (
    SETTINGS,
    SHORT,
    blind,
    drive,
    follow,
    place_errors,
    short_drive,
    true_camera,
)

from circumspect.sensing import RgbdFrame
from circumspect.tracking import Tracker


def stamped(angles: np.ndarray, stamps: list[float]) -> list[RgbdFrame]:
    """A drive without odometry."""
    frames = zip(drive(angles), stamps, strict=True)
    return [replace(frame, stamp=stamp, odometry=None) for frame, stamp in frames]


@pytest.mark.parametrize("gap", [1e-3, 1e-4])
def test_a_camera_that_stands_stays_in_pairs_of_frames(gap: float) -> None:
    angles = np.full(16, np.radians(60.0))
    stamps = [number // 2 * 0.1 + number % 2 * gap for number in range(len(angles))]
    tracked = follow(stamped(angles, stamps), Tracker(true_camera(float(angles[0])), SETTINGS))
    assert all(estimate.reliable for estimate in tracked)
    assert place_errors(tracked, angles).max() < 0.006


@pytest.mark.parametrize("gap", [2e-3, 1e-4])
def test_a_frame_stamped_on_arrival_does_not_lose_a_moving_camera(gap: float) -> None:
    angles = np.radians(np.arange(60.0, 70.0, 0.5))
    stamps = [number * 0.1 for number in range(len(angles))]
    stamps[12] = stamps[13] - gap
    tracked = follow(stamped(angles, stamps), Tracker(true_camera(float(angles[0])), SETTINGS))
    assert all(estimate.reliable for estimate in tracked)
    assert place_errors(tracked, angles).max() < 0.015


def test_a_lost_camera_does_not_move_on() -> None:
    angles = np.radians(np.arange(60.0, 66.0, 0.5))
    frames = stamped(angles, [number * 0.1 for number in range(len(angles))])
    tracker = Tracker(true_camera(float(angles[0])), SETTINGS)
    follow(frames, tracker)
    # The sensor is dead and shows a wall in front of the lens.
    wall = np.full_like(frames[-1].depth, 0.6)
    dead = [replace(frames[-1], depth=wall, stamp=2.0 + number * 0.1) for number in range(30)]
    before = tracker.track(replace(blind(frames[-1]), stamp=1.9)).T_map_camera
    tracked = follow(dead, tracker)
    assert tracked[-1].lost
    off: RigidTransform = before.inv() * tracked[-1].T_map_camera
    assert np.linalg.norm(off.translation) < 0.1


@pytest.mark.parametrize("with_odometry", [True, False])
def test_tracking_continues_after_a_clock_jump_of_decades(with_odometry: bool) -> None:
    frames = [
        replace(
            frame,
            stamp=frame.stamp + (1.7e9 if number > 4 else 0.0),
            odometry=frame.odometry if with_odometry else None,
        )
        for number, frame in enumerate(short_drive()[:8])
    ]
    tracked = follow(frames)
    assert all(np.isfinite(estimate.T_map_camera.as_matrix()).all() for estimate in tracked)
    assert all(np.linalg.eigvalsh(estimate.covariance)[0] > 0 for estimate in tracked)


def test_odometry_with_a_huge_covariance_is_harmless() -> None:
    frames = [
        replace(frame, odometry=replace(frame.odometry, covariance=np.eye(3) * 1e300 * (n > 0)))
        for n, frame in enumerate(short_drive()[:6])
    ]
    assert place_errors(follow(frames), SHORT[:6]).max() < 0.03


@pytest.mark.parametrize("size", [1e9, 1e300])
def test_an_impossible_odometry_jump_counts_as_no_odometry_for_that_step(size: float) -> None:
    frames = list(short_drive()[:7])
    odometry = frames[4].odometry
    there = replace(odometry.T_odom_base, x=size)
    frames[4] = replace(frames[4], odometry=replace(odometry, T_odom_base=there))
    tracked = follow(frames)
    assert [estimate.source for estimate in tracked[1:4]] == ["odometry"] * 3
    assert "odometry" not in {estimate.source for estimate in tracked[4:6]}
    assert tracked[6].source == "odometry"
    assert place_errors(tracked, SHORT[:7]).max() < 0.02
