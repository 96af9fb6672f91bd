"""Base class of pose estimators, and the estimator for known poses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import composed
from circumspect.sensing import RgbdFrame
from circumspect.tracking.pose_estimate import PoseEstimate


class PoseEstimator(ABC):
    """Estimates the pose of every frame; frames are passed in the order of their stamps."""

    @abstractmethod
    def track(self, frame: RgbdFrame) -> PoseEstimate:
        """Estimate the pose of a frame from all frames so far.

        Raises:
            InputError: The first pose is unknown.
        """

    @property
    def corrections(self) -> int:
        """Number of corrections of earlier poses; each of them changes `corrected`."""
        return 0

    def keyframe_pose(self, number: int) -> RigidTransform:
        """Current `T_map_camera` of a reference keyframe.

        Raises:
            KeyError: No estimate has this reference keyframe.
        """
        raise KeyError(number)

    def skip(self, frame: RgbdFrame) -> None:  # noqa: B027 - nothing to do is a fine default
        """Process a frame without usable depth, in place of `track`."""

    def process_pending(self) -> None:  # noqa: B027 - nothing to do is a fine default
        """Do the deferred work of the last frame: extend and correct the map.

        Otherwise the next call of `track` does it. It may run in the background while no other
        method is called.
        """

    def finalise(self) -> None:  # noqa: B027 - nothing to do is a fine default
        """Do all deferred work after the last frame; more frames may follow."""

    def corrected(self, estimates: Sequence[PoseEstimate]) -> list[RigidTransform]:
        """Current `T_map_camera` of earlier frames.

        Args:
            estimates: Estimates of this estimator.
        """
        return [estimate.T_map_camera for estimate in estimates]


class KnownPoses(PoseEstimator):
    """Takes the given poses of frames as true."""

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        """The given pose of the frame.

        Raises:
            InputError: The frame has no pose.
        """
        base = None
        if frame.T_base_camera is not None:
            base = PlanarPose.from_transform(composed(frame.pose, frame.T_base_camera.inv()))
        return PoseEstimate(frame.pose, inliers=int(frame.valid.sum()), T_map_base=base)
