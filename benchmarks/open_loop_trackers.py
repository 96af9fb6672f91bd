"""Trackers that `benchmarks.open_loop` compares: the package's own, and baselines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from benchmarks.open_loop import TrackedPose
from benchmarks.plain_gicp import PlainGicp
from circumspect.errors import InputError
from circumspect.geometry.composition import between, distances
from circumspect.motion import MotionModel, PoseWithCovariance
from circumspect.registration import Scan, ScanSurface, SurfaceMap, register
from circumspect.sensing import RgbdFrame
from circumspect.tracking import PoseEstimate, Tracker, TrackingSettings
from circumspect.tracking.fixed_lag_smoother import FixedLagSmoother

EXACT = 1e-8 * np.eye(6)
"""(6, 6) covariance of the first pose [rad, m]."""
SCALE_SIGMA = 0.05
"""Standard deviation of the odometry scale."""
MEDIAN_DEPTH_M = 1.5
"""Depth that scales the distance between keyframes [m]."""
GICP_MAX_DEPTH_M = 2.5
"""Maximum depth for small_gicp [m]; without a model of the depth error it drifts with more."""
MIN_POINTS = 10
"""Minimum number of points of a scan with normals."""


class OwnTracker:
    """The package's `Tracker`, with all active patches."""

    def __init__(self, settings: TrackingSettings) -> None:
        """Start without a map."""
        self._poses = Tracker(settings=settings)
        self._tracked: list[PoseEstimate] = []

    def track(self, frame: RgbdFrame) -> TrackedPose:
        """See `OpenLoopTracker.track`."""
        pose = self._poses.track(frame)
        self._tracked.append(pose)
        covariance = None if pose.covariance is None else np.asarray(pose.covariance, float)
        return TrackedPose(pose.T_map_camera.as_matrix(), pose.reliable, covariance)

    def finalise(self) -> NDArray[np.float64]:
        """See `OpenLoopTracker.finalise`."""
        self._poses.finalise()
        return np.stack([T.as_matrix() for T in self._poses.corrected(self._tracked)])


class Baseline:
    """A tracker without corrections that flags every pose as reliable."""

    def __init__(self, settings: TrackingSettings) -> None:
        """Start without a map."""
        self.settings = settings
        self._before: RgbdFrame | None = None
        self._live: list[NDArray[np.float64]] = []

    def track(self, frame: RgbdFrame) -> TrackedPose:
        """See `OpenLoopTracker.track`."""
        before = self._before
        pose = self.start(frame) if before is None else self.follow(before, frame)
        self._before = frame
        self._live.append(pose.T_map_camera)
        return pose

    def finalise(self) -> NDArray[np.float64]:
        """See `OpenLoopTracker.finalise`."""
        return np.stack(self._live)

    def start(self, frame: RgbdFrame) -> TrackedPose:
        """Estimate the pose of the first frame."""
        raise NotImplementedError

    def follow(self, before: RgbdFrame, frame: RgbdFrame) -> TrackedPose:
        """Estimate the pose of a later frame, given the previous one."""
        raise NotImplementedError


class WheelsOnly(Baseline):
    """Dead reckoning; the pose is constant while there is no odometry."""

    def start(self, frame: RgbdFrame) -> TrackedPose:
        """See `Baseline.start`.

        Raises:
            InputError: There is no odometry.
        """
        if frame.odometry is None:
            raise InputError("there is no odometry")
        self._pose = first_pose(frame).as_matrix()
        return TrackedPose(self._pose)

    def follow(self, before: RgbdFrame, frame: RgbdFrame) -> TrackedPose:
        """See `Baseline.follow`."""
        step = odometry_step(before, frame)
        self._pose = self._pose if step is None else self._pose @ step
        return TrackedPose(self._pose)


class GicpWithOdometry(Baseline):
    """small_gicp's scan-to-model registration; odometry or constant velocity as initial guess."""

    def start(self, frame: RgbdFrame) -> TrackedPose:
        """See `Baseline.start`."""
        self._gicp = PlainGicp(min(self.settings.scan.max_depth, GICP_MAX_DEPTH_M), threads=1)
        placed = self._gicp.track(replace(frame, T_map_camera=first_pose(frame)))
        return TrackedPose(placed.as_matrix())

    def follow(self, before: RgbdFrame, frame: RgbdFrame) -> TrackedPose:
        """See `Baseline.follow`."""
        placed = self._gicp.track(frame, odometry_step(before, frame))
        return TrackedPose(placed.as_matrix())


class KernelOnly(Baseline):
    """The registration kernel with the odometry prior; without odometry, constant velocity.

    Frames far from all others in the map extend it. No pose is rejected or corrected.
    """

    def start(self, frame: RgbdFrame) -> TrackedPose:
        """See `Baseline.start`."""
        self._map = SurfaceMap(self.settings.scan.voxel)
        self._in_map: list[NDArray[np.float64]] = []
        self._velocity, self._time = np.eye(4), 1.0
        return self._placed(frame, PoseWithCovariance(first_pose(frame).as_matrix(), EXACT))

    def follow(self, before: RgbdFrame, frame: RgbdFrame) -> TrackedPose:
        """See `Baseline.follow`."""
        last, s, model = self._pose, self.settings, MotionModel(self.settings.motion)
        time = frame.stamp - before.stamp
        motion = model.by_odometry(before, frame)
        if motion is None:
            motion = model.by_constant_velocity(self._velocity, self._time, time, 0.0)
        smoother = FixedLagSmoother.from_pose(last.T_map_camera, last.covariance, SCALE_SIGMA)
        prior = smoother.predicted(motion)
        found = register(
            Scan.from_frame(frame, s.scan), self._map,
            RigidTransform.from_matrix(prior.T_map_camera), prior.information, s.registration,
        )  # fmt: skip
        T_map_camera = found.T_map_camera.as_matrix()
        self._velocity = np.linalg.inv(last.T_map_camera) @ T_map_camera
        self._time = time
        return self._placed(
            frame, PoseWithCovariance(T_map_camera, np.linalg.inv(found.information))
        )

    def _placed(self, frame: RgbdFrame, pose: PoseWithCovariance) -> TrackedPose:
        self._pose, matrix = pose, np.asarray(pose.T_map_camera, float)
        if self._is_far(matrix):
            scan = Scan.from_frame(frame, self.settings.scan)
            if len(scan) >= MIN_POINTS:
                surface = ScanSurface.from_scan(scan)
                self._map = self._map.with_surface(surface, RigidTransform.from_matrix(matrix))
                self._in_map.append(matrix)
        return TrackedPose(matrix, covariance=np.asarray(pose.covariance, float))

    def _is_far(self, matrix: NDArray[np.float64]) -> bool:
        if not self._in_map:
            return True
        shift, turn = distances(np.stack(self._in_map), matrix)
        s = self.settings.keyframes
        baseline = s.max_baseline * MEDIAN_DEPTH_M
        return bool(np.maximum(shift / baseline, turn / s.max_rotation).min() >= 1)


def first_pose(frame: RgbdFrame) -> RigidTransform:
    """First pose of a map: the frame's pose, else its odometry, else its mount."""
    for pose in (frame.T_map_camera, frame.T_odom_camera, frame.T_base_camera):
        if pose is not None:
            return pose
    return RigidTransform.identity()


def odometry_step(before: RgbdFrame, frame: RgbdFrame) -> NDArray[np.float64] | None:
    """(4, 4) motion of the camera by odometry; None if one of the frames has none."""
    one, other = before.T_odom_camera, frame.T_odom_camera
    if one is None or other is None:
        return None
    return between(one, other).as_matrix()
