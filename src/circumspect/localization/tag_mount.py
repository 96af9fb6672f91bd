"""Mount and picture of the tag on the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.localization.opencv import opencv

CORNERS = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Corners of the black square of side 1: x to the right of the print, y to its top, in the order
of `TagDetector`: lower left, lower right, upper right, upper left."""
MAX_ROBOT_SIZE_M = 100.0
"""Maximum distance of the tag from the base, and maximum height [m]."""
MODULES = 8
"""Side of the black square of a 36h11 tag, in modules."""


@dataclass(frozen=True)
class TagMount:
    """A horizontal AprilTag on the robot, face up.

    Attributes:
        tag_id: Number in the family 36h11.
        size: Side of the black square without the white border [m].
        height: Height of the tag above the floor [m].
        T_base_tag: Pose on the base; x is to the right of the print, y to its top.

    Raises:
        InputError: A value is invalid.
    """

    tag_id: int = 0
    size: float = 0.20
    height: float = 0.30
    T_base_tag: PlanarPose = PlanarPose()  # noqa: RUF009 - frozen

    def __post_init__(self) -> None:
        require_tag_id(self.tag_id)
        if not 0.01 <= self.size <= 2:
            raise InputError(f"the tag size must be from 0.01 to 2 m, not {self.size} m")
        if not 0 <= self.height < MAX_ROBOT_SIZE_M:
            raise InputError(
                f"the tag height must be from 0 to {MAX_ROBOT_SIZE_M:g} m, not {self.height:g} m"
            )
        x, y = self.T_base_tag.x, self.T_base_tag.y
        if not max(abs(x), abs(y)) < MAX_ROBOT_SIZE_M:
            raise InputError(f"the tag must be on the robot, not ({x:g}, {y:g}) m from its base")

    @property
    def corners_xy(self) -> NDArray[np.float64]:
        """(4, 2) corners of the black square on the base [m], in the order of `CORNERS`."""
        return self.T_base_tag.applied(self.size * CORNERS)


def require_tag_id(tag_id: int) -> None:
    """Check a tag number of the family 36h11.

    Raises:
        InputError: There is no such tag.
    """
    if not 0 <= tag_id <= 586:
        raise InputError(f"tags of the family 36h11 have the numbers 0 to 586, not {tag_id}")


def tag_picture(tag_id: int, border: int = 1) -> NDArray[np.uint8]:
    """Picture of a tag with its white border, one pixel per module.

    Args:
        tag_id: Number in the family 36h11.
        border: Width of the white border, in modules.

    Returns:
        (8 + 2 border, 8 + 2 border), 0 or 255; row 0 is the print's top.

    Raises:
        InputError: There is no such tag.
        MissingExtraError: OpenCV is not installed.
    """
    require_tag_id(tag_id)
    cv2 = opencv()
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    # OpenCV's family is upside down compared with the printed tags.
    black = np.rot90(cv2.aruco.generateImageMarker(dictionary, tag_id, MODULES), 2)
    return np.pad(black, border, constant_values=255)
