"""Depth images averaged over small blocks of pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing import _native


@dataclass(frozen=True, eq=False)
class DepthBlocks:
    """Means over square blocks of pixels on one surface.

    The inverse depth q = 1/z is averaged. It is linear in the pixel on a plane, so the mean of a
    block is the value at its centre (approximately, if the block is partly masked).

    Attributes:
        inverse_depth: (rows, columns) float32 [1/m], NaN where a block is empty or contains an
            edge.
        counts: (rows, columns) int32 number of valid pixels; 0 where `inverse_depth` is NaN.
        camera: Camera of the whole image.
        block: Side of the blocks [px].
        jump: Relative depth difference of neighbours above which they are on different surfaces.
    """

    inverse_depth: NDArray[np.float32]
    counts: NDArray[np.int32]
    camera: PinholeCamera
    block: int
    jump: float

    @classmethod
    def of(
        cls,
        depth: NDArray[np.floating],
        camera: PinholeCamera,
        block: int,
        mask: NDArray[np.bool_] | None = None,
        jump: float = 0.04,
    ) -> DepthBlocks:
        """Average an image.

        Args:
            depth: (height, width) [m], NaN invalid.
            camera: The camera.
            block: Side of the blocks [px].
            mask: (height, width) pixels to use; None for all.
            jump: See the class.
        """
        height, width = depth.shape
        rows, columns = -(-height // block), -(-width // block)
        mean, counts = np.empty((rows, columns), np.float32), np.empty((rows, columns), np.int32)
        wanted = None if mask is None else np.ascontiguousarray(mask, bool)
        image = np.ascontiguousarray(depth, np.float32)
        _native.block_means(image, wanted, block, jump, mean, counts)
        return cls(mean, counts, camera, block, jump)

    @property
    def pixels(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """((rows, 1), (1, columns)): v and u of the centres of the blocks [px]."""
        rows, columns = self.counts.shape
        middle = (self.block - 1) / 2
        v = np.arange(rows, dtype=np.float32)[:, None] * self.block + middle
        u = np.arange(columns, dtype=np.float32)[None, :] * self.block + middle
        return v, u

    def points_xyz(
        self, rows: NDArray[np.integer], columns: NDArray[np.integer]
    ) -> NDArray[np.floating]:
        """Points of some blocks.

        Args:
            rows: (n,) of the blocks.
            columns: (n,) of the blocks.

        Returns:
            (n, 3) [m] in the optical frame; NaN where a block has no depth.
        """
        v, u = self.pixels
        z = 1 / self.inverse_depth[rows, columns]
        x = (u[0, columns] - self.camera.cx) / self.camera.fx * z
        y = (v[rows, 0] - self.camera.cy) / self.camera.fy * z
        return np.stack([x, y, z], axis=-1)

    def normals(self) -> NDArray[np.float32]:
        """Surface normals, directed towards the camera.

        With q = a u + b v + c, the normal of the plane is parallel to (a fx, b fy, a cx + b cy +
        c). Differences are taken between blocks, but not across jumps in depth.

        Returns:
            (rows, columns, 3) float32 unit vectors, optical frame; NaN where unknown.
        """
        a, b = self._slopes(1), self._slopes(0)
        v, u = self.pixels
        u, v = u - self.camera.cx, v - self.camera.cy
        away = np.stack(
            [a * self.camera.fx, b * self.camera.fy, self.inverse_depth - a * u - b * v], axis=-1
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            return -away / np.sqrt(np.einsum("ijk,ijk->ij", away, away))[..., None]

    def _slopes(self, axis: int) -> NDArray[np.floating]:
        """Change of q per pixel: mean of the differences to both neighbours without a jump."""
        along = np.moveaxis(self.inverse_depth, axis, 0)
        step = np.diff(along, axis=0)
        with np.errstate(invalid="ignore"):
            step[~(np.abs(step) <= self.jump * np.maximum(along[1:], along[:-1]))] = np.nan
        missing = np.full((1, along.shape[1]), np.nan, np.float32)
        before, after = np.concatenate([missing, step]), np.concatenate([step, missing])
        counts = np.isfinite(before).astype(np.float32) + np.isfinite(after)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = (np.nan_to_num(before) + np.nan_to_num(after)) / counts
        return np.moveaxis(mean, 0, axis) / self.block
