"""Sums over voxels, as sorted tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.mapping import _native

BITS = 20
"""Bits for each coordinate of a voxel: a million voxels along each axis."""

HALVED = sum(((1 << (BITS - 1)) - 1) << (BITS * axis) for axis in range(3))
"""What is left of a number whose coordinates are each halved."""
CENTRED = sum(1 << (BITS - 2 + BITS * axis) for axis in range(3))
"""Halves of coordinates that are counted from the middle have lost half of it."""


def voxel_keys(points_xyz: NDArray[np.floating], side: float) -> NDArray[np.int64]:
    """(n,) one number for the voxel of each point.

    Args:
        points_xyz: (n, 3) [m].
        side: Of the voxels [m].
    """
    return _native.packed_cells(np.ascontiguousarray(points_xyz), side, BITS, 1 << (BITS - 1))


def coarser_keys(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) the numbers of voxels of twice the side that (n,) voxels lie in."""
    return ((keys >> 1) & HALVED) + CENTRED


def largest(keys: NDArray[np.int64], values: NDArray[np.floating]) -> NDArray[np.float64]:
    """(m,) the largest of the (n,) values of each key, in ascending order of the keys."""
    if len(keys) == 0:
        return np.empty(0)
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    return np.maximum.reduceat(values[order], first)


@dataclass(frozen=True, eq=False)
class VoxelSums:
    """For each voxel the sum of some columns.

    Attributes:
        keys: (n,) int64, ascending, each once.
        totals: (n, columns) float64.
    """

    keys: NDArray[np.int64]
    totals: NDArray[np.float64]

    @classmethod
    def empty(cls, columns: int) -> VoxelSums:
        """No voxels."""
        return cls(np.empty(0, np.int64), np.empty((0, columns)))

    @classmethod
    def of(cls, keys: NDArray[np.int64], values: NDArray[np.floating]) -> VoxelSums:
        """Sum rows of equal keys.

        Args:
            keys: (n,) in any order.
            values: (n, columns).
        """
        return cls(*_native.row_sums(keys, values))

    def __len__(self) -> int:
        return len(self.keys)

    def plus(self, *others: VoxelSums) -> VoxelSums:
        """The sums of all, to the last bit as if the others were added one by one."""
        if len(others) == 1:
            keys, totals = others[0].keys, others[0].totals
        else:
            keys = np.concatenate([self.keys[:0], *(other.keys for other in others)])
            order = np.argsort(keys, kind="stable")
            totals = np.concatenate([self.totals[:0], *(other.totals for other in others)])
            keys, totals = keys[order], totals[order]
        return VoxelSums(*_native.table_sum(self.keys, self.totals, keys, totals))
