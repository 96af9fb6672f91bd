"""Base class of segmentations, and the detection of flying pixels."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing import _native
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_plane import FloorProblem
from circumspect.sensing.rgbd_frame import RgbdFrame

MAX_JUMP_SIGMAS = 4 * float(np.sqrt(2))
"""Maximum depth difference of neighbours on a surface, in standard deviations of one depth."""


class Segmentation(ABC):
    """Finds the pixels of the object."""

    @abstractmethod
    def object_mask(
        self, frame: RgbdFrame, known_xyz: NDArray[np.floating] | None = None
    ) -> NDArray[np.bool_]:
        """Compute the mask of the object.

        Args:
            frame: A frame with a pose, which may be approximate.
            known_xyz: (n, 3) known points of the object [m], map frame, to select the same object.

        Returns:
            (height, width) bool; all False if the object is not visible.

        Raises:
            InputError: The frame has no pose.
        """

    def problem(self, frame: RgbdFrame) -> FloorProblem | None:  # noqa: ARG002
        """Check whether the frame contradicts the assumed pose of the camera.

        Args:
            frame: A frame with a pose.

        Returns:
            The problem; None if there is none, or if no assumption is made.
        """
        return None


def continuous_pixels(
    depth: NDArray[np.floating],
    camera: PinholeCamera,
    noise: DepthNoise,
    max_incidence: float = 1.4,
) -> NDArray[np.bool_]:
    """Pixels that lie on a surface.

    A pixel on a surface, its rim included, continues to at least one of its two neighbours
    along rows and along columns. A pixel between an edge and the background continues to none.

    Args:
        depth: (height, width) [m], NaN invalid.
        camera: The camera.
        noise: Its noise; differences within four standard deviations are no jump.
        max_incidence: Surfaces seen at more than this angle [rad] count as jumps.

    Returns:
        (height, width) bool; False where the depth is invalid.
    """
    image = np.ascontiguousarray(depth, np.float32)
    keep = np.empty(image.shape, bool)
    slope = float(np.tan(max_incidence)) / camera.fx
    _native.continuous(image, noise.coefficients(camera), MAX_JUMP_SIGMAS, slope, keep)
    return keep
