"""The pinhole camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class PinholeCamera:
    """A camera without distortion; pixel (0, 0) is the centre of the top left pixel.

    The optical frame looks along +z with +x to the right and +y down (REP 103).

    Attributes:
        width, height: image size [px].
        fx, fy: focal lengths [px].
        cx, cy: principal point [px].
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @classmethod
    def xtion(cls) -> PinholeCamera:
        """The depth camera of the Asus Xtion PRO: 640x480, f = 570.3 px."""
        return cls(640, 480, 570.3, 570.3, 319.5, 239.5)

    @property
    def rays_xyz(self) -> NDArray[np.float64]:
        """(height, width, 3): the point at depth 1 m along each pixel's ray, optical frame."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack(
            [(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones(u.shape)], axis=-1
        )

    def back_project(
        self, depth: NDArray[np.floating], mask: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64]:
        """Points of the valid pixels of a depth image.

        Args:
            depth: (height, width) [m] along z; NaN is invalid.
            mask: (height, width) the pixels wanted; None means all.

        Returns:
            (n, 3) [m] points in the optical frame, row by row.
        """
        wanted = np.isfinite(depth) if mask is None else np.isfinite(depth) & mask
        v, u = np.nonzero(wanted)
        z = depth[v, u].astype(np.float64)
        return np.stack([(u - self.cx) / self.fx * z, (v - self.cy) / self.fy * z, z], axis=1)
