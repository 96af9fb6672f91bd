"""Registrations that start from several poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import CAMERA, SETTINGS, SURFACES, T_BASE_CAMERA, UNDISTORTED, true_base

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import distances
from circumspect.motion import PoseWithCovariance
from circumspect.sensing import RgbdFrame
from circumspect.simulation import Scene, SimulatedCamera, Station, Surface, block
from circumspect.tracking import Tracker, start_poses
from circumspect.tracking.start_poses import MAX_STARTS_PER_SIDE, SPACING

SLATS = tuple(
    Surface(f"slat {n}", block((-0.55 + 0.1 * n, -0.24, 0.1), (-0.5 + 0.1 * n, -0.2, 0.7)))
    for n in range(12)
)
FENCE = (Surface("object", block((-0.6, -0.2, 0.0), (0.6, 0.2, 0.8))), *SLATS, SURFACES[2])
"""A thing with slats on its front, on a floor: every 0.1 m along it there is a local minimum."""
TURNS = (0, 0, 0, 7, 0, -7, 0, 7, 0, -7, 0)
"""How far the robot is turned [degrees], twice a second."""


def prior(sigmas: list[float]) -> PoseWithCovariance:
    return PoseWithCovariance(np.eye(4), np.diag([*np.radians(sigmas), 0.1, 0.1, 0.1]) ** 2)


def is_between_steps(sigma: float) -> bool:
    """Whether rounding cannot change the number of starts."""
    steps = np.radians(sigma) / SPACING
    return bool(abs(steps - round(steps)) > 1e-6)


def test_a_known_rotation_has_one_start() -> None:
    known = prior([2.9, 0.3, 0.1])
    np.testing.assert_array_equal(start_poses.start_poses(known), [known.T_map_camera])


@given(st.lists(st.floats(0.1, 60.0).filter(is_between_steps), min_size=3, max_size=3))
def test_starts_cover_one_standard_deviation_of_each_axis(sigmas: list[float]) -> None:
    starts = np.stack(start_poses.start_poses(prior(sigmas)))
    translation, rotation = distances(starts, np.eye(4))
    assert translation.max() == 0 == rotation[0]
    steps = rotation / SPACING
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    wanted = [int(np.radians(s) / SPACING) for s in sigmas]
    found = len(starts) // 2
    if sum(wanted) <= MAX_STARTS_PER_SIDE and max(sorted(wanted)[:2]) <= MAX_STARTS_PER_SIDE // 3:
        assert (found, round(steps.max())) == (sum(wanted), max(wanted))
    assert min(max(wanted), MAX_STARTS_PER_SIDE // 3) <= found
    assert found <= min(sum(wanted), MAX_STARTS_PER_SIDE)


def turning_on_the_spot() -> tuple[list[RgbdFrame], list[RigidTransform]]:
    """Frames of a robot without odometry in front of the fence, and its true poses."""
    scene, still = Scene(FENCE), Station(0.0, RigidTransform.identity())
    camera = SimulatedCamera(scene, lambda: still, CAMERA, UNDISTORTED, 0)
    place = true_base(-np.pi / 2)
    frames, truth = [], []
    for number, turn in enumerate(TURNS):
        base = PlanarPose(place.x, place.y, place.yaw + float(np.radians(turn)))
        T_world_camera = base.as_transform() * T_BASE_CAMERA
        frame = camera.photograph(Station(0.5 * number, T_world_camera))
        frames.append(replace(frame, T_map_camera=None, T_base_camera=T_BASE_CAMERA))
        truth.append(T_world_camera)
    return frames, truth


def worst_reliable_m(frames: list[RgbdFrame], truth: list[RigidTransform]) -> float:
    tracker = Tracker(truth[0], SETTINGS)
    estimates = [tracker.track(frame) for frame in frames]
    assert sum(estimate.reliable for estimate in estimates) > len(frames) / 2
    return max(
        float(np.linalg.norm((true.inv() * estimate.T_map_camera).translation))
        for true, estimate in zip(truth, estimates, strict=True)
        if estimate.reliable
    )


def test_a_robot_that_turns_to_and_fro_does_not_slide_along_a_fence(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """From the predicted pose alone registration converges to a neighbouring slat."""
    frames, truth = turning_on_the_spot()
    assert worst_reliable_m(frames, truth) < 0.01
    monkeypatch.setattr(start_poses, "MAX_STARTS_PER_SIDE", 0)
    assert worst_reliable_m(frames, truth) > 0.05
