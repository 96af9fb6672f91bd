"""Candidate poses of a lost camera."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.spatial.transform import RigidTransform
from tracking_world import SETTINGS, SQUARE, SURFACES, blind, drive, follow, true_camera

from circumspect.geometry.composition import distances
from circumspect.registration import Scan
from circumspect.simulation import Surface
from circumspect.tracking import Tracker
from circumspect.tracking.relocaliser import (
    MAX_CANDIDATES,
    MIN_SEPARATION_M,
    MIN_SEPARATION_ROTATION,
    _separated,
    candidate_poses,
)


def tracked_round(angles: np.ndarray, surfaces: tuple[Surface, ...] = SURFACES) -> Tracker:
    """A tracker after a drive, its map in the frame of the world."""
    tracker = Tracker(true_camera(float(angles[0])), SETTINGS)
    follow(drive(angles, surfaces=surfaces), tracker)
    tracker.finalise()
    return tracker


def test_a_candidate_is_near_the_truth() -> None:
    """The nearest keyframe is 8° and 0.2 m away."""
    keyframes = tracked_round(np.radians(np.arange(-30, 25, 4.0))).keyframes
    angle = float(np.radians(30.0))
    scan = Scan.from_frame(drive(np.array([angle]))[0], SETTINGS.scan)
    candidates = candidate_poses(scan, keyframes)
    assert 0 < len(candidates) <= MAX_CANDIDATES
    poses = np.stack([candidate.T_map_camera for candidate in candidates])
    assert distances(poses, true_camera(angle).as_matrix())[0].min() < 0.05


def test_without_scan_or_map_there_are_no_candidates() -> None:
    frame = drive(np.array([0.0]))[0]
    tracker = Tracker(settings=SETTINGS)
    assert candidate_poses(Scan.from_frame(frame), tracker.keyframes) == []
    tracker.track(frame)
    assert candidate_poses(Scan.from_frame(blind(frame)), tracker.keyframes) == []


def test_candidates_at_a_square_pillar_are_on_different_sides() -> None:
    angles = np.radians(np.arange(5, 365, 10.0))
    keyframes = tracked_round(angles, SQUARE).keyframes
    scan = Scan.from_frame(drive(angles[4:5], surfaces=SQUARE)[0])
    candidates = candidate_poses(scan, keyframes)
    assert len(candidates) >= 2
    sides = set()
    for candidate in candidates:
        x, y = candidate.T_map_camera[:2, 3]
        sides.add(round(float(np.degrees(np.arctan2(y, x)) - np.degrees(angles[4])) / 90) % 4)
    assert len(sides) >= 2


def test_candidates_start_apart() -> None:
    keyframes = tracked_round(np.radians(np.arange(-30, 60, 4.0))).keyframes
    for a, b in combinations(_separated(list(keyframes.poses)), 2):
        translation, rotation = distances(a, b)
        assert translation >= MIN_SEPARATION_M or rotation >= MIN_SEPARATION_ROTATION


def test_a_robot_lost_at_a_square_pillar_is_not_reliable() -> None:
    """It is carried by 45°, and four sides look like what it sees then."""
    angles = np.radians(np.arange(5, 366, 10.0))
    away = np.radians(np.arange(50, 62, 2.5))
    frames = drive(np.concatenate([angles, away]), surfaces=SQUARE)
    tracker = Tracker(true_camera(float(angles[0])), SETTINGS)
    before = follow(frames[: len(angles)], tracker)
    assert before[-1].reliable
    last = frames[len(angles) - 1]
    carried = [replace(frame, odometry=last.odometry) for frame in frames[len(angles) :]]
    for estimate, angle in zip(follow(carried, tracker), away, strict=True):
        off: RigidTransform = true_camera(float(angle)).inv() * estimate.T_map_camera
        assert not estimate.reliable or np.linalg.norm(off.translation) < 0.05
