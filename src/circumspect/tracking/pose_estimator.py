"""Estimates camera poses of frames: the interface, and the case of known poses."""

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
            InputError: There is nothing to start from.
        """

    @property
    def corrections(self) -> int:
        """How often earlier poses were corrected; each time `corrected` changes."""
        return 0

    def keyframe_pose(self, number: int) -> RigidTransform:
        """Current `T_map_camera` of a keyframe that an estimate named as its reference.

        Raises:
            KeyError: No estimate did.
        """
        raise KeyError(number)

    def skip(self, frame: RgbdFrame) -> None:  # noqa: B027 - nothing to do is a fine default
        """Take note of a frame without usable depth, in place of `track`."""

    def process_pending(self) -> None:  # noqa: B027 - nothing to do is a fine default
        """Do the work that the last frame left: the map grows and is corrected.

        The next call of `track` does it otherwise. It may run in the background while nothing else
        of this estimator is used.
        """

    def finalise(self) -> None:  # noqa: B027 - nothing to do is a fine default
        """Do all work that was deferred: no more frames come for now."""

    def corrected(self, estimates: Sequence[PoseEstimate]) -> list[RigidTransform]:
        """Current `T_map_camera` of earlier frames.

        Args:
            estimates: Estimates of this estimator.
        """
        return [estimate.T_map_camera for estimate in estimates]


class KnownPoses(PoseEstimator):
    """Every frame has a pose, which is taken as true."""

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        """The pose of the frame.

        Raises:
            InputError: The frame has none.
        """
        base = None
        if frame.T_base_camera is not None:
            base = PlanarPose.from_transform(composed(frame.pose, frame.T_base_camera.inv()))
        return PoseEstimate(frame.pose, inliers=int(frame.valid.sum()), T_map_base=base)
