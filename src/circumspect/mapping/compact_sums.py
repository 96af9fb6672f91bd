"""Sums over voxels in half the memory, to be kept for long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.voxel_sums import VoxelSums
from circumspect.mapping.frame_share import NORMAL, POINT, WEIGHT


@dataclass(frozen=True, eq=False)
class CompactSums:
    """What a `FrameShare` sums up, in single precision.

    Means are kept, not sums, whose rounding would add up from frame to frame; and points from a
    place near by: single precision tells 0.2 µm at 3 m, but a centimetre at 100 km.

    Attributes:
        keys: (n,) int64, those of the sums.
        means: (n, columns) float32, see `FrameShare`: weight, point from the centre on and
            normal by the weight, frames.
        centre_xyz: (3,) [m].
    """

    keys: NDArray[np.int64]
    means: NDArray[np.float32]
    centre_xyz: NDArray[np.float64]

    @classmethod
    def of(cls, sums: VoxelSums, centre_xyz: NDArray[np.floating]) -> CompactSums:
        """Round sums.

        Args:
            sums: In the columns of a `FrameShare`.
            centre_xyz: (3,) [m] a place near their points.
        """
        means, weights = sums.totals.copy(), sums.totals[:, WEIGHT, None]
        means[:, POINT] = means[:, POINT] / weights - centre_xyz
        means[:, NORMAL] /= weights
        return cls(sums.keys, means.astype(np.float32), np.asarray(centre_xyz, np.float64))

    def expanded(self) -> VoxelSums:
        """The sums in double precision."""
        totals = self.means.astype(np.float64)
        weights = totals[:, WEIGHT, None]
        totals[:, POINT] = weights * (totals[:, POINT] + self.centre_xyz)
        totals[:, NORMAL] *= weights
        return VoxelSums(self.keys, totals)
