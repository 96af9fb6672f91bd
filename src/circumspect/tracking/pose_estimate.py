"""The estimated pose of one frame, with its status and uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose, se3
from circumspect.geometry.composition import between, composed, orthonormal
from circumspect.pose_graph import KeyframeMap
from circumspect.sensing import RgbdFrame
from circumspect.tracking.hypothesis import Hypothesis
from circumspect.tracking.tracking_state import TrackingState

ACCURATE_SIGMAS = (float(np.radians(1.0)), 0.05 / 3)
"""Standard deviations [rad, m] of an accurate pose: 3° and 50 mm are three of them."""


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """The estimated pose of one frame.

    Attributes:
        T_map_camera: The pose, optical frame.
        state: State of the tracker.
        reason: Why the pose is not reliable; empty if it is.
        unverified: Whether the pose is not reliable only because the scans contain too little
            information, without a contradiction.
        source: Source of the prediction: "odometry", "slipping wheels", "constant velocity",
            "standing still", "dead reckoning", "relocalisation", "initial pose" or "given".
        converged: Whether the registration converged.
        inliers: Points of the frame that support the pose.
        residual: Root mean square distance of the inliers to the map [m].
        covariance: (6, 6) of right perturbations since the first pose [rad, m], optical frame;
            None if the pose is taken as true.
        hypotheses: Number of hypotheses.
        T_map_base: Pose of the robot on the floor; None if the mount is unknown.
        T_map_odom: Correction of the odometry's drift (REP 105); None without odometry.
        reference: Number of the reference keyframe; corrections of it move the pose as well.
        T_reference_camera: The pose relative to that keyframe.
    """

    T_map_camera: RigidTransform
    state: TrackingState = TrackingState.TRACKING
    reason: str = ""
    unverified: bool = False
    source: str = "given"
    converged: bool = True
    inliers: int = 0
    residual: float = 0.0
    covariance: NDArray[np.floating] | None = None
    hypotheses: int = 1
    T_map_base: PlanarPose | None = None
    T_map_odom: PlanarPose | None = None
    reference: int | None = None
    T_reference_camera: RigidTransform | None = None

    @classmethod
    def from_hypothesis(
        cls, hypothesis: Hypothesis, frame: RgbdFrame, keyframes: KeyframeMap
    ) -> Self:
        """The estimate of a frame from a hypothesis.

        Args:
            hypothesis: The most likely hypothesis, continued by the frame.
            frame: The frame.
            keyframes: The map.
        """
        pose, found = hypothesis.pose, hypothesis.registration
        T_map_camera = RigidTransform.from_matrix(pose.T_map_camera)
        covariance, T_reference_camera = pose.covariance, None
        if hypothesis.reference is not None:
            covariance = keyframes.covariance(pose, hypothesis.reference)
            reference = keyframes[hypothesis.reference]
            T_reference_camera = orthonormal(reference.relative_pose(pose.T_map_camera))
        T_map_base = T_map_odom = None
        if frame.T_base_camera is not None:
            T_map_base = PlanarPose.from_transform(
                composed(T_map_camera, frame.T_base_camera.inv())
            )
            if frame.odometry is not None:
                T_map_odom = T_map_base @ frame.odometry.T_odom_base.inverse()
        return cls(
            T_map_camera,
            source=hypothesis.motion,
            converged=found is not None and found.converged,
            inliers=0 if found is None else found.inliers,
            residual=0.0 if found is None else found.residual,
            covariance=covariance,
            T_map_base=T_map_base,
            T_map_odom=T_map_odom,
            reference=hypothesis.reference,
            T_reference_camera=T_reference_camera,
        )

    @property
    def reliable(self) -> bool:
        """Whether the pose is consistent with the map, so that frames may be fused at it.

        The local map may itself have drifted; see `accurate`.
        """
        return self.state is TrackingState.TRACKING

    @property
    def lost(self) -> bool:
        """Whether the camera may be anywhere."""
        return self.state is TrackingState.LOST

    @property
    def sigmas(self) -> tuple[float, float] | None:
        """Largest standard deviations of rotation [rad] and translation [m] since the first pose.

        None if the pose is taken as true.
        """
        return None if self.covariance is None else se3.largest_deviations(self.covariance)

    @property
    def accurate(self) -> bool:
        """Whether the pose is reliable and three standard deviations are within 3° and 50 mm."""
        rotation, translation = self.sigmas or (0.0, 0.0)
        return (
            self.reliable and rotation <= ACCURATE_SIGMAS[0] and translation <= ACCURATE_SIGMAS[1]
        )

    def at(self, T_map_camera: RigidTransform) -> PoseEstimate:
        """The same estimate at a corrected pose."""
        if self.T_map_base is None:
            return replace(self, T_map_camera=T_map_camera)
        moved = composed(T_map_camera, between(self.T_map_camera, self.T_map_base.as_transform()))
        base = PlanarPose.from_transform(moved)
        odom = self.T_map_odom
        if odom is not None:
            odom = base @ self.T_map_base.inverse() @ odom
        return replace(self, T_map_camera=T_map_camera, T_map_base=base, T_map_odom=odom)
