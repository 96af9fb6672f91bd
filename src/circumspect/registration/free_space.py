"""Free space in front of the camera, as one frame shows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from circumspect.geometry import PinholeCamera
from circumspect.sensing import RgbdFrame

BLOCK_PX = 8
"""Depths are reduced over square blocks of this side [px]."""
MIN_VALID_FRACTION = 0.9
"""A block with a smaller fraction of valid pixels is unknown."""
MARGIN_M, MARGIN_GROWTH_PER_M = 0.06, 0.01
"""Only points in front of a surface by more than this [m], plus this times the squared depth [1/m],
are free. Poses have small errors, and depth noise grows with the squared depth."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Lower bound of the free depth in each direction of a frame.

    Attributes:
        free_depth: (rows, columns) float32 [m] smallest depth in a block of pixels and its
            neighbours; 0 if one of them is unknown.
        camera: The camera of the whole frame.
    """

    free_depth: NDArray[np.float32]
    camera: PinholeCamera

    @classmethod
    def from_frame(cls, frame: RgbdFrame) -> FreeSpace:
        """Compute the free space of a frame."""
        rows, columns = frame.camera.height // BLOCK_PX, frame.camera.width // BLOCK_PX
        cut = frame.depth[: rows * BLOCK_PX, : columns * BLOCK_PX]
        # Rows first: whole lines of the image are quick to reduce.
        lines = cut.reshape(rows, BLOCK_PX, columns * BLOCK_PX)
        measured = np.isfinite(lines).sum(axis=1, dtype=np.int32)
        counts = measured.reshape(rows, columns, BLOCK_PX).sum(axis=2)
        valid = counts >= MIN_VALID_FRACTION * BLOCK_PX**2
        line = np.fmin.reduce(lines, axis=1).reshape(rows, columns, BLOCK_PX)
        smallest = np.where(valid, np.fmin.reduce(line, axis=2), 0)
        return cls(
            ndimage.minimum_filter(smallest, 3, mode="nearest").astype(np.float32), frame.camera
        )

    def contains(self, points_xyz: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Whether points lie in free space.

        Args:
            points_xyz: (n, 3) [m] optical frame.

        Returns:
            (n,); False for points out of view.
        """
        depth, free = points_xyz[:, 2], self._free_depth_towards(points_xyz)
        return (free > 0) & (depth + MARGIN_M + MARGIN_GROWTH_PER_M * depth**2 < free)

    def agrees_with(self, points_xyz: NDArray[np.floating], tolerance: float) -> NDArray[np.bool_]:
        """Whether points lie at the depth where free space ends.

        Args:
            points_xyz: (n, 3) [m] optical frame.
            tolerance: Largest difference of the depths [m].

        Returns:
            (n,); False for points out of view.
        """
        free = self._free_depth_towards(points_xyz)
        return (free > 0) & (np.abs(points_xyz[:, 2] - free) < tolerance)

    def _free_depth_towards(self, points_xyz: NDArray[np.floating]) -> NDArray[np.float64]:
        """(n,) [m] `free_depth` in the directions of points; 0 out of view."""
        x, y, z = points_xyz.T
        in_front = z > 1e-6
        depth = np.where(in_front, z, 1.0)
        column = (x / depth * self.camera.fx + self.camera.cx) // BLOCK_PX
        row = (y / depth * self.camera.fy + self.camera.cy) // BLOCK_PX
        rows, columns = self.free_depth.shape
        inside = in_front & (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        free = np.zeros(len(points_xyz))
        free[inside] = self.free_depth[row[inside].astype(np.intp), column[inside].astype(np.intp)]
        return free
