"""Poses by registration of every frame to the scene, fused with odometry."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.mapping import motion, se3
from circumspect.mapping.gate import GateSettings
from circumspect.mapping.motion import Belief, MotionSettings
from circumspect.mapping.pose_estimator import GATE_OPEN, PoseEstimate, PoseEstimator
from circumspect.mapping.registration import Registration, RegistrationSettings, register
from circumspect.mapping.scan import Scan, ScanSettings
from circumspect.mapping.scene_map import SceneMap
from circumspect.sensing import Odometry, RgbdFrame


@dataclass(frozen=True)
class TrackingSettings:
    """How frames are followed.

    Attributes:
        scan: How frames are thinned.
        registration: How they are fitted.
        motion: What is expected between frames.
        gate: What is believed.
        key_shift, key_turn: The scene map grows by a frame that is this far [m], [rad] from all
            that it is made of.
        certain: Largest standard deviation of the place [m] of a pose to build on.
    """

    scan: ScanSettings = field(default_factory=ScanSettings)
    registration: RegistrationSettings = field(default_factory=RegistrationSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    gate: GateSettings = field(default_factory=GateSettings)
    key_shift: float = 0.2
    key_turn: float = float(np.radians(12.0))
    certain: float = 0.02


class RegisteredPoses(PoseEstimator):
    """Follows a camera by scan-to-model registration from the odometry prior.

    The map frame is the odom frame of the first frame; without odometry it is the frame in which
    the first pose is given.
    """

    def __init__(
        self,
        T_map_first: RigidTransform | None = None,
        settings: TrackingSettings | None = None,
    ) -> None:
        """Begin with an empty map.

        Args:
            T_map_first: Pose of the first frame; None means that of the first frame's odometry
                and mount, or else the one that the first frame brings.
            settings: How frames are followed.
        """
        self.settings = settings or TrackingSettings()
        self.scene = SceneMap(self.settings.scan.voxel)
        self._T_map_first = T_map_first
        self._keys: list[RigidTransform] = []
        self._belief: Belief | None = None
        self._stamp = 0.0
        self._odometry: Odometry | None = None
        self._motion = RigidTransform.identity()
        self._motion_time = 0.0

    def estimate(self, frame: RgbdFrame) -> PoseEstimate:
        """See `PoseEstimator.estimate`."""
        scan = Scan.of(frame, self.settings.scan)
        if self._belief is None:
            return self._first(frame, scan)

        # Where the camera should be, and what the frame says
        believed, source = self._predicted(frame)
        information = np.linalg.inv(believed.covariance)
        found = register(
            scan, self.scene, believed.T_map_camera, information, self.settings.registration
        )

        # Both together where the frame is to be believed, else the prediction
        gate = self.settings.gate.verdict(found, information)
        if gate == GATE_OPEN:
            believed = Belief(found.T_map_camera, np.linalg.inv(found.information))
        self._remember(frame, believed)
        if gate == GATE_OPEN:
            self._grow(scan, believed.T_map_camera)
        return self._told(frame, believed, gate, source, found)

    def _first(self, frame: RgbdFrame, scan: Scan) -> PoseEstimate:
        T = self._T_map_first
        if T is None and frame.odometry is not None and frame.T_base_camera is not None:
            T = frame.odometry.T_odom_base.as_transform() * frame.T_base_camera
        if T is None:
            T = frame.T_map_camera
        if T is None:
            raise InputError(
                f"the frame at {frame.stamp:.3f} s has neither odometry nor pose; registration "
                "needs the pose of the first frame"
            )
        believed = Belief(T, np.diag([1e-4] * 3 + [1e-4] * 3) ** 2)
        self._remember(frame, believed)
        self._motion_time = 0.0
        self._grow(scan, T)
        return self._told(frame, believed, GATE_OPEN, "first frame", None)

    def _predicted(self, frame: RgbdFrame) -> tuple[Belief, str]:
        assert self._belief is not None
        s, mount, time = self.settings.motion, frame.T_base_camera, frame.stamp - self._stamp
        if frame.odometry is not None and self._odometry is not None and mount is not None:
            step = motion.wheel_motion(self._odometry, frame.odometry, mount, s)
            return self._belief.moved(*step).held_to_floor(mount, s), motion.ODOMETRY
        step = motion.steady_motion(self._motion, self._motion_time, time, s)
        believed = self._belief.moved(*step)
        if mount is not None:
            believed = believed.held_to_floor(mount, s)
        return believed, motion.CONSTANT_VELOCITY

    def _remember(self, frame: RgbdFrame, believed: Belief) -> None:
        if self._belief is not None:
            self._motion = self._belief.T_map_camera.inv() * believed.T_map_camera
            self._motion_time = frame.stamp - self._stamp
        self._belief, self._stamp, self._odometry = believed, frame.stamp, frame.odometry

    def _grow(self, scan: Scan, T_map_camera: RigidTransform) -> None:
        s = self.settings
        for key in self._keys:
            apart = se3.log(key.inv() * T_map_camera)
            if np.linalg.norm(apart[:3]) < s.key_turn and np.linalg.norm(apart[3:]) < s.key_shift:
                return
        self._keys.append(T_map_camera)
        self.scene = self.scene.with_scan(scan, scan.normals_xyz(), T_map_camera)

    def _told(
        self,
        frame: RgbdFrame,
        believed: Belief,
        gate: str,
        source: str,
        found: Registration | None,
    ) -> PoseEstimate:
        T_map_base = T_map_odom = None
        if frame.T_base_camera is not None:
            T_map_base = PlanarPose.from_transform(
                believed.T_map_camera * frame.T_base_camera.inv()
            )
            if frame.odometry is not None:
                T_map_odom = T_map_base @ frame.odometry.T_odom_base.inverse()
        place = float(np.sqrt(np.linalg.eigvalsh(believed.covariance[3:, 3:])[-1]))
        return PoseEstimate(
            believed.T_map_camera,
            converged=found is None or found.converged,
            inliers=0 if found is None else found.inliers,
            residual=0.0 if found is None else found.residual,
            gate=gate,
            covariance=believed.covariance,
            T_map_base=T_map_base,
            T_map_odom=T_map_odom,
            certain=gate == GATE_OPEN or place < self.settings.certain,
            prior=source,
        )
