"""What a tag looks like."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.localization.opencv import opencv
from circumspect.localization.tag_mount import require_tag_id

MODULES = 8
"""Black square of a 36h11 tag, in modules."""


def tag_picture(tag_id: int, border: int = 1) -> NDArray[np.uint8]:
    """The modules of a tag, one pixel each, in its white border.

    Args:
        tag_id: Of the family 36h11.
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
    # OpenCV holds the family upside down; this is how its makers print it.
    black = np.rot90(cv2.aruco.generateImageMarker(dictionary, tag_id, MODULES), 2)
    return np.pad(black, border, constant_values=255)
