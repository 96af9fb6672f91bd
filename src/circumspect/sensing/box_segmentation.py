"""Segmentation of the object by a box."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError, printable
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.pixel_rays import along_axis
from circumspect.sensing.rgbd_frame import RgbdFrame
from circumspect.sensing.segmentation import Segmentation, continuous_pixels


@dataclass(frozen=True, eq=False)
class BoxSegmentation(Segmentation):
    """The pixels inside a box that is aligned with the axes of the map frame.

    Attributes:
        corner_a: (3,) one corner in the map frame [m].
        corner_b: (3,) the opposite corner [m].
        noise: Depth noise of the camera, used to remove flying pixels.

    Raises:
        InputError: A corner is not three finite numbers, or the box is flat.
    """

    corner_a: ArrayLike
    corner_b: ArrayLike
    noise: DepthNoise = field(default_factory=DepthNoise)
    low_xyz: NDArray[np.float64] = field(init=False)
    high_xyz: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        corners = np.stack([_corner(self.corner_a), _corner(self.corner_b)])
        if (corners[0] == corners[1]).any():
            raise InputError(f"the box {corners.tolist()} is flat; its corners must be opposite")
        object.__setattr__(self, "low_xyz", corners.min(axis=0))
        object.__setattr__(self, "high_xyz", corners.max(axis=0))

    def object_mask(
        self,
        frame: RgbdFrame,
        known_xyz: NDArray[np.floating] | None = None,  # noqa: ARG002 - the box says it all
    ) -> NDArray[np.bool_]:
        """See `Segmentation.object_mask`."""
        mask = continuous_pixels(frame.depth, frame.camera, self.noise)
        matrix = frame.pose.as_matrix()
        for axis in range(3):
            place = matrix[axis, 3]
            across = frame.depth * along_axis(frame.camera, matrix[axis, :3])
            with np.errstate(invalid="ignore"):
                mask &= across >= np.float32(self.low_xyz[axis] - place)
                mask &= across <= np.float32(self.high_xyz[axis] - place)
        return mask


def _corner(given: ArrayLike) -> NDArray[np.float64]:
    try:
        corner = np.asarray(given, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        corner = np.empty(0)
    if corner.shape != (3,) or not np.isfinite(corner).all():
        raise InputError(
            f"a corner of a box must be three finite numbers, not {printable(repr(given)[:80])}"
        )
    return corner
