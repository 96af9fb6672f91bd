"""Where each frame was taken from: the interface, and the case where it is known."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose, se3
from circumspect.geometry.composition import between, composed
from circumspect.mapping.gate import GATE_OPEN
from circumspect.sensing import RgbdFrame

LOST = "lost: "
"""What a gate's reason begins with once several frames contradicted all that is known."""

SURE = (float(np.radians(1.0)), 0.05 / 3)
"""Standard deviations [rad, m] of a pose that is told as sure: 3° and 50 mm, to three of them."""


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """The pose of one frame and how it came about.

    Attributes:
        T_map_camera: The pose, optical frame.
        converged: Whether the estimator reached a solution of its own. It is told, as its inliers
            and residual are, whether it was believed or not.
        inliers: Points of the frame that support it.
        residual: Root mean square distance of the inliers to the scene [m].
        gate: "open" where the estimate is used as it is, else the reason why it is not and the
            prior stands in its place; it begins with `LOST` where the camera may be anywhere.
        covariance: (6, 6) of changes T exp(φ, ρ) of the pose, turn [rad] before shift [m],
            optical frame; None where the pose is taken as true.
        T_map_base: The robot's pose on the floor; None where its mount is not known.
        T_map_odom: What corrects the odometry's drift (REP 105); None without odometry.
        doubt: Why the pose is not `certain`; empty where it is.
        prior: What the pose was expected from: "odometry", "constant velocity", "standing
            still", ….
        anchor: Number of the keyframe that the pose moves with when it is corrected, if any; of
            a frame that becomes a keyframe the one before.
        T_anchor_camera: The pose in that keyframe's.
        unsure: Number among the poses that are not certain, by which it is corrected once one is.
    """

    T_map_camera: RigidTransform
    converged: bool = True
    inliers: int = 0
    residual: float = 0.0
    gate: str = GATE_OPEN
    covariance: NDArray[np.floating] | None = None
    T_map_base: PlanarPose | None = None
    T_map_odom: PlanarPose | None = None
    doubt: str = ""
    prior: str = "given"
    anchor: int | None = None
    T_anchor_camera: RigidTransform | None = None
    unsure: int | None = None

    @property
    def certain(self) -> bool:
        """Whether the pose is good enough to build on (fuse, plan, drive).

        It is well known in the map about it, which may itself have drifted; see `sure`.
        """
        return not self.doubt

    @property
    def remark(self) -> str:
        """What speaks against the registration or the pose; empty where nothing does."""
        gate = "" if self.gate == GATE_OPEN else self.gate
        return "; ".join(filter(None, (gate, self.doubt)))

    @property
    def lost(self) -> bool:
        """Whether the camera may be anywhere."""
        return self.gate.startswith(LOST)

    @property
    def deviations(self) -> tuple[float, float] | None:
        """Largest standard deviations of the turn [rad] and of the place [m], since the first pose.

        None where the pose is taken as true.
        """
        return None if self.covariance is None else se3.largest_deviations(self.covariance)

    @property
    def sure(self) -> bool:
        """Whether the pose is certain, and by its covariance within 3° and 50 mm of the truth."""
        turn, place = self.deviations or (0.0, 0.0)
        return self.certain and turn <= SURE[0] and place <= SURE[1]

    def at(self, T_map_camera: RigidTransform) -> PoseEstimate:
        """The same with a corrected pose."""
        if self.T_map_base is None:
            return replace(self, T_map_camera=T_map_camera)
        moved = composed(T_map_camera, between(self.T_map_camera, self.T_map_base.as_transform()))
        base = PlanarPose.from_transform(moved)
        odom = self.T_map_odom
        if odom is not None:
            odom = base @ self.T_map_base.inverse() @ odom
        return replace(self, T_map_camera=T_map_camera, T_map_base=base, T_map_odom=odom)


class PoseEstimator(ABC):
    """Says where frames were taken from; frames are given in the order of their stamps."""

    @abstractmethod
    def estimate(self, frame: RgbdFrame) -> PoseEstimate:
        """Where a frame was taken from, by all that is known until now.

        Raises:
            InputError: There is nothing to base a belief on.
        """

    @property
    def corrections(self) -> int:
        """How often poses told earlier were corrected; each time `corrected` changes."""
        return 0

    def anchor_pose(self, number: int) -> RigidTransform:
        """`T_map_camera`, now, of a keyframe that an estimate named as its anchor.

        Raises:
            KeyError: No estimate did.
        """
        raise KeyError(number)

    def pass_over(self, frame: RgbdFrame) -> None:  # noqa: B027 - nothing to do is a fine default
        """Hear of a frame that shows nothing of use, in the place of `estimate`."""

    def catch_up(self) -> None:  # noqa: B027 - nothing to do is a fine default
        """Do what the last estimate left to be done; the next one does it otherwise.

        It may run beside all that asks nothing of this estimator.
        """

    def settle(self) -> None:  # noqa: B027 - nothing to do is a fine default
        """Do what was put off: no more frames come for now."""

    def corrected(self, told: Sequence[PoseEstimate]) -> list[RigidTransform]:
        """The poses of earlier frames by what is known now.

        Args:
            told: Estimates that this estimator gave.

        Returns:
            `T_map_camera` of each.
        """
        return [estimate.T_map_camera for estimate in told]


class KnownPoses(PoseEstimator):
    """Every frame brings its pose, and it is taken as true."""

    def estimate(self, frame: RgbdFrame) -> PoseEstimate:
        """The frame's own pose.

        Raises:
            InputError: The frame has none.
        """
        base = None
        if frame.T_base_camera is not None:
            base = PlanarPose.from_transform(composed(frame.pose, frame.T_base_camera.inv()))
        return PoseEstimate(frame.pose, inliers=int(frame.valid.sum()), T_map_base=base)
