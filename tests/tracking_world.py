"""A robot that drives round a box in a small room, with drifting odometry and small pictures."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.registration import Scan
from circumspect.sensing import DepthNoise, Odometry, RgbdFrame
from circumspect.simulation import Scene, SimulatedCamera, Station, Surface, block, looking_at
from circumspect.tracking import PoseEstimate, Tracker, TrackingSettings

CAMERA = PinholeCamera(240, 180, 214.0, 214.0, 119.5, 89.5)
UNDISTORTED = DepthNoise(systematic_disparity=0.0)
"""Noise of the simulated camera, which has no systematic errors."""
SETTINGS = TrackingSettings.for_noise(UNDISTORTED)
RADIUS, HEIGHT = 1.5, 1.1
T_BASE_CAMERA = looking_at((0.0, 0.0, HEIGHT), (0.0, RADIUS, 0.3))
SLIP = 0.04
"""The wheels claim this share more than the truth."""
SURFACES = (
    Surface("object", block((-0.3, -0.2, 0.0), (0.3, 0.2, 0.5))),
    Surface("box", block((0.3, -0.1, 0.0), (0.45, 0.15, 0.3))),
    Surface("floor", block((-6, -6, -0.1), (6, 6, 0.0))),
    Surface("wall", block((-1.0, 1.9, 0.0), (3.0, 2.0, 2.0))),
    Surface("clutter", block((-1.4, -2.2, 0.0), (-1.0, -2.0, 0.8))),
    Surface("post", block((0.9, -2.0, 0.0), (1.1, -1.8, 1.2))),
)

SQUARE = (Surface("object", block((-0.25, -0.25, 0.0), (0.25, 0.25, 0.8))), SURFACES[2])
"""A pillar that looks the same from its four sides, on a floor."""


def true_base(angle: float) -> PlanarPose:
    return PlanarPose(RADIUS * np.cos(angle), RADIUS * np.sin(angle), angle + np.pi / 2)


@lru_cache(maxsize=4)
def true_camera(angle: float) -> RigidTransform:
    return true_base(angle).as_transform() * T_BASE_CAMERA


def drive(
    angles: np.ndarray, seed: int = 0, surfaces: tuple[Surface, ...] = SURFACES
) -> list[RgbdFrame]:
    """Frames with odometry and mount, without poses; one a second."""
    camera = SimulatedCamera(Scene(surfaces), lambda: Station(0.0, RigidTransform.identity()),
                             CAMERA, UNDISTORTED, seed)  # fmt: skip
    odom, covariance, frames = PlanarPose(), np.zeros((3, 3)), []
    for number, angle in enumerate(angles):
        if number:
            step = true_base(angles[number - 1]).inverse() @ true_base(angle)
            distance = float(np.hypot(step.x, step.y))
            odom = odom @ PlanarPose(step.x * (1 + SLIP), step.y, step.yaw * (1 + SLIP))
            covariance = (
                covariance + np.diag([0.05 * distance, 0.05 * distance, 0.05 * distance]) ** 2
            )
        frame = camera.photograph(Station(float(number), true_camera(float(angle))))
        odometry = Odometry(float(number), odom, covariance)
        frames.append(
            replace(frame, T_map_camera=None, odometry=odometry, T_base_camera=T_BASE_CAMERA)
        )
    return frames


@lru_cache(maxsize=2)
def short_drive() -> tuple[RgbdFrame, ...]:
    """16 frames over 40°, from where two faces of the box are in view."""
    return tuple(drive(SHORT))


SHORT = np.radians(20 + np.arange(16) * 2.5)


def blind(frame: RgbdFrame) -> RgbdFrame:
    return replace(frame, depth=np.full(frame.depth.shape, np.nan))


def place_errors(estimates: list, angles: np.ndarray) -> np.ndarray:
    """(n,) [m] distances of estimated and true camera places, the first pose aligned."""
    T_map_true = estimates[0].T_map_camera * true_camera(float(angles[0])).inv()
    true = np.array([(T_map_true * true_camera(float(angle))).translation for angle in angles])
    found = np.array([estimate.T_map_camera.translation for estimate in estimates])
    return np.linalg.norm(found - true, axis=1)


def follow(frames, tracker: Tracker | None = None) -> list[PoseEstimate]:
    tracker = tracker or Tracker(settings=SETTINGS)
    return [tracker.track(frame) for frame in frames]


def bare_wall(rng: np.random.Generator, noise: float = 2e-3) -> Scan:
    """A wall of 2 m by 1.2 m, 1.5 m ahead of the camera."""
    u, v = np.meshgrid(np.arange(66), np.arange(40))
    cells = np.stack([u.ravel(), v.ravel()], axis=1) - [33, 20]
    flat = 0.03 * (cells + rng.uniform(0, 1, cells.shape))
    depth = 1.5 + rng.normal(0, noise, len(flat))
    return Scan.with_white_noise(np.column_stack([flat, depth]), np.full(len(flat), 2e-3))
