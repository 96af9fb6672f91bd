"""The pinhole camera."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError


@dataclass(frozen=True)
class PinholeCamera:
    """A camera without distortion; pixel (0, 0) is the centre of the top left pixel.

    The optical frame has +z forward, +x to the right and +y down (REP 103).

    Attributes:
        width, height: image size [px].
        fx, fy: focal lengths [px].
        cx, cy: principal point [px].

    Raises:
        GeometryError: An empty image, or focal lengths that are not positive.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise GeometryError(f"the image has no pixels: {self.width} x {self.height}")
        if not (0 < self.fx < math.inf and 0 < self.fy < math.inf):
            raise GeometryError(f"focal lengths must be positive: {self.fx}, {self.fy}")
        if not (math.isfinite(self.cx) and math.isfinite(self.cy)):
            raise GeometryError(f"the principal point is not finite: {self.cx}, {self.cy}")

    @classmethod
    def xtion(cls) -> PinholeCamera:
        """The depth camera of the Asus Xtion PRO: 640x480, f = 570.3 px."""
        return cls(640, 480, 570.3, 570.3, 319.5, 239.5)

    @property
    def rays_xyz(self) -> NDArray[np.float64]:
        """(height, width, 3): the point at depth 1 m along each pixel's ray, optical frame."""
        rays = np.ones((self.height, self.width, 3))
        rays[..., 0] = (np.arange(self.width) - self.cx) / self.fx
        rays[..., 1] = ((np.arange(self.height) - self.cy) / self.fy)[:, None]
        return rays

    def back_project(
        self, depth: NDArray[np.floating], mask: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64]:
        """Points of the valid pixels of a depth image.

        Args:
            depth: (height, width) [m] along z; NaN is invalid.
            mask: (height, width) selected pixels; None means all.

        Returns:
            (n, 3) [m] points in the optical frame, row by row.

        Raises:
            GeometryError: The image or the mask is not as large as the camera's image.
        """
        for name, image in (("depth", depth), ("mask", mask)):
            if image is not None and image.shape != (self.height, self.width):
                raise GeometryError(
                    f"{name} must have shape {(self.height, self.width)}, not {image.shape}"
                )
        wanted = np.isfinite(depth) if mask is None else np.isfinite(depth) & mask
        v, u = np.nonzero(wanted)
        z = depth[v, u].astype(np.float64)
        return np.stack([(u - self.cx) / self.fx * z, (v - self.cy) / self.fy * z, z], axis=1)

    def project(self, points_xyz: ArrayLike) -> NDArray[np.float64]:
        """Image coordinates of points; the inverse of `back_project`.

        Args:
            points_xyz: (n, 3) [m] in the optical frame.

        Returns:
            (n, 2) [px]: u to the right, v down, not limited to the image; NaN for points that are
            not in front of the camera.

        Raises:
            ValueError: The points are not (n, 3).
        """
        x, y, z = np.asarray(points_xyz, dtype=np.float64).T
        depth = np.where(z > 0, z, np.nan)
        return np.stack([x / depth * self.fx + self.cx, y / depth * self.fy + self.cy], axis=1)
