"""The interface of everything that tells an object from what is round it."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from circumspect.sensing.floor_check import FloorFault
from circumspect.sensing.rgbd_frame import RgbdFrame


class Segmentation(ABC):
    """Finds the object's pixels."""

    @abstractmethod
    def object_mask(
        self, frame: RgbdFrame, known_xyz: NDArray[np.floating] | None = None
    ) -> NDArray[np.bool_]:
        """The pixels that show the object.

        Args:
            frame: A frame with a pose, at least a guess.
            known_xyz: (n, 3) [m] points of the object seen so far, map frame; helps to stay
                with the same object.

        Returns:
            (height, width) bool; all False where the object is not in view.

        Raises:
            InputError: The frame has no pose.
        """

    def fault(self, frame: RgbdFrame) -> FloorFault | None:  # noqa: ARG002
        """What in a frame contradicts that the camera is where it is said to be.

        Args:
            frame: A frame with a pose.

        Returns:
            The reason; None where nothing does, or where nothing is taken for granted.
        """
        return None
