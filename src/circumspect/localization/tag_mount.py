"""Where the tag is on the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose

CORNERS = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Of the black square of side 1: x to the right of the print, y to its top, in the order in which
`TagDetector` tells them: lower left, lower right, upper right, upper left."""
LARGEST_ROBOT = 100.0
"""No tag on a robot is so far from its base, nor so high [m]."""


@dataclass(frozen=True)
class TagMount:
    """An AprilTag that lies flat on the robot, face up.

    Attributes:
        tag_id: Of the family 36h11.
        size: Side of the black square [m]; the white border around it does not count.
        height: Of the tag above the floor [m].
        T_base_tag: Its place on the base; its x axis runs to the right of the print, y to its top.

    Raises:
        InputError: A value makes no sense.
    """

    tag_id: int = 0
    size: float = 0.20
    height: float = 0.30
    T_base_tag: PlanarPose = PlanarPose()  # noqa: RUF009 - frozen

    def __post_init__(self) -> None:
        require_tag_id(self.tag_id)
        if not 0.01 <= self.size <= 2:
            raise InputError(f"a tag is from 0.01 to 2 m large, not {self.size} m")
        if not 0 <= self.height < LARGEST_ROBOT:
            raise InputError(
                f"a tag lies at a height from 0 to {LARGEST_ROBOT:g} m, not {self.height:g} m"
            )
        x, y = self.T_base_tag.x, self.T_base_tag.y
        if not max(abs(x), abs(y)) < LARGEST_ROBOT:
            raise InputError(f"a tag lies on the robot, not at ({x:g}, {y:g}) m from its base")

    @property
    def corners_xy(self) -> NDArray[np.float64]:
        """(4, 2) [m] of the black square on the base, in the order of `CORNERS`."""
        return self.T_base_tag.applied(self.size * CORNERS)


def require_tag_id(tag_id: int) -> None:
    """Check that the family 36h11 has such a tag.

    Raises:
        InputError: It has not.
    """
    if not 0 <= tag_id <= 586:
        raise InputError(f"tags of the family 36h11 have the numbers 0 to 586, not {tag_id}")
