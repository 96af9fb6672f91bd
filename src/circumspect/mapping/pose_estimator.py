"""Where each frame was taken from: the interface, and the case where it is known."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.sensing import RgbdFrame

if TYPE_CHECKING:
    from circumspect.mapping.object_model import ObjectModel

GATE_OPEN = "open"


@dataclass(frozen=True)
class PoseEstimate:
    """The pose of one frame and how it came about.

    Attributes:
        T_map_camera: The pose, optical frame.
        converged: Whether the estimator reached a solution of its own.
        inliers: Points of the frame that support it.
        residual: Root mean square distance of the inliers to the model [m].
        gate: "open" where the estimate is used as it is, else the reason why it is not and the
            prior stands in its place.
    """

    T_map_camera: RigidTransform
    converged: bool = True
    inliers: int = 0
    residual: float = 0.0
    gate: str = GATE_OPEN


class PoseEstimator(ABC):
    """Says where a frame was taken from."""

    @abstractmethod
    def prior(self, frame: RgbdFrame) -> RigidTransform:
        """`T_map_camera` as believed before the frame's depth is looked at.

        Raises:
            InputError: There is nothing to base a belief on.
        """

    @abstractmethod
    def estimate(
        self, frame: RgbdFrame, object_mask: NDArray[np.bool_], model: ObjectModel
    ) -> PoseEstimate:
        """`T_map_camera` after the frame's depth was compared with the model.

        Args:
            frame: The frame, with the prior as its pose.
            object_mask: (height, width) the object's pixels.
            model: What is known of the object.
        """


class KnownPoses(PoseEstimator):
    """Every frame brings its pose, and it is taken as true."""

    def prior(self, frame: RgbdFrame) -> RigidTransform:
        """The frame's own pose.

        Raises:
            InputError: The frame has none.
        """
        return frame.pose

    def estimate(
        self,
        frame: RgbdFrame,
        object_mask: NDArray[np.bool_],
        model: ObjectModel,  # noqa: ARG002 - nothing to compare: the pose is known
    ) -> PoseEstimate:
        """See `PoseEstimator.estimate`."""
        return PoseEstimate(frame.pose, inliers=int(object_mask.sum()))
