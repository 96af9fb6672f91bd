"""What a frame showed to be empty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from circumspect.geometry import PinholeCamera
from circumspect.sensing import RgbdFrame

BLOCK = 8
"""Side of the blocks of pixels [px] that are asked together."""
MEASURED = 0.9
"""A block with a smaller share of valid pixels tells nothing."""
SLACK, SLACK_GROWTH = 0.06, 0.01
"""Only what is this much [m], and so much more per squared depth [1/m], before a surface is in
front of it: poses err a little, and depths err with their square."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """How far one can look, at least, in each direction of a frame.

    Attributes:
        clear: (rows, columns) float32 [m] depth of the nearest thing in a block of pixels and in
            those round it; 0 where one of them tells nothing.
        camera: The camera of the whole frame.
    """

    clear: NDArray[np.float32]
    camera: PinholeCamera

    @classmethod
    def of(cls, frame: RgbdFrame) -> FreeSpace:
        """What a frame shows."""
        rows, columns = frame.camera.height // BLOCK, frame.camera.width // BLOCK
        cut = frame.depth[: rows * BLOCK, : columns * BLOCK]
        # Rows first: whole lines of the image are quick to reduce.
        lines = cut.reshape(rows, BLOCK, columns * BLOCK)
        measured = np.isfinite(lines).sum(axis=1, dtype=np.int32)
        valid = measured.reshape(rows, columns, BLOCK).sum(axis=2) >= MEASURED * BLOCK**2
        line = np.fmin.reduce(lines, axis=1).reshape(rows, columns, BLOCK)
        nearest = np.fmin.reduce(line, axis=2)
        clear = np.where(valid, nearest, 0)
        return cls(
            ndimage.minimum_filter(clear, 3, mode="nearest").astype(np.float32), frame.camera
        )

    def holds(self, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points lie where the frame looked through.

        Args:
            points_xyz: (n, 3) [m] optical frame.

        Returns:
            (n,); False also for what was out of view.
        """
        depth, clear = points_xyz[:, 2], self._clear_towards(points_xyz)
        return (clear > 0) & (depth + SLACK + SLACK_GROWTH * depth**2 < clear)

    def shows(self, points_xyz: NDArray[np.float64], within: float) -> NDArray[np.bool_]:
        """Which points lie about where the frame saw something.

        Args:
            points_xyz: (n, 3) [m] optical frame.
            within: Up to this distance [m] along the optical axis.
        """
        clear = self._clear_towards(points_xyz)
        return (clear > 0) & (np.abs(points_xyz[:, 2] - clear) < within)

    def _clear_towards(self, points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) [m] `clear` in the directions of some points; 0 out of view."""
        x, y, z = points_xyz.T
        ahead = z > 1e-6
        depth = np.where(ahead, z, 1.0)
        column = (x / depth * self.camera.fx + self.camera.cx) // BLOCK
        row = (y / depth * self.camera.fy + self.camera.cy) // BLOCK
        rows, columns = self.clear.shape
        inside = ahead & (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        clear = np.zeros(len(points_xyz))
        clear[inside] = self.clear[row[inside].astype(np.intp), column[inside].astype(np.intp)]
        return clear
