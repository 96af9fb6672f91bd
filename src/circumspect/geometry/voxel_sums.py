"""Keys of voxels, and sums over voxels as tables sorted by key."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import _native

KEY_BITS = 20
"""Bits per coordinate of a voxel key: 2²⁰ voxels along each axis."""

_HALF_MASK = sum(((1 << (KEY_BITS - 1)) - 1) << (KEY_BITS * axis) for axis in range(3))
"""Clears the bits that a shift of a key by one moves from one coordinate into the next."""
_HALF_OFFSET = sum(1 << (KEY_BITS - 2 + KEY_BITS * axis) for axis in range(3))
"""Restores the offset of the coordinates, since a shift by one halves it."""


def packed_cells(
    points_xyz: NDArray[np.floating], side: float, bits: int, offset: int = 0
) -> NDArray[np.int64]:
    """(n,) key of the cubic cell that each point lies in.

    Args:
        points_xyz: (n, 3) [m].
        side: Side of the cells [m].
        bits: Bits per coordinate, 1 to 20. Keys repeat after 2^bits cells along an axis.
        offset: Added to each coordinate, in cells.

    Raises:
        ValueError: `side` or `bits` is out of range.
    """
    return _native.packed_cells(np.ascontiguousarray(points_xyz), side, bits, offset)


def voxel_keys(points_xyz: NDArray[np.floating], side: float) -> NDArray[np.int64]:
    """(n,) key of the voxel that each point lies in.

    Args:
        points_xyz: (n, 3) [m].
        side: Side of the voxels [m].
    """
    return packed_cells(points_xyz, side, KEY_BITS, 1 << (KEY_BITS - 1))


def coarser_keys(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) keys of the voxels with twice the side that contain the voxels of (n,) `keys`."""
    return ((keys >> 1) & _HALF_MASK) + _HALF_OFFSET


def patch_keys(
    points_xyz: NDArray[np.floating], normals_xyz: NDArray[np.floating], side: float
) -> NDArray[np.int64]:
    """(n,) key of the surface patch that each point belongs to.

    A patch is the part of the surface in one voxel whose normals are nearest to the same one of the
    six axis directions. So the two sides of a thin board are different patches.

    Args:
        points_xyz: (n, 3) [m].
        normals_xyz: (n, 3).
        side: Side of the voxels [m].
    """
    return _native.patch_keys(voxel_keys(points_xyz, side), np.ascontiguousarray(normals_xyz))


def group_sizes(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) number of rows that have the same key as each of the (n,) rows."""
    return _native.group_sizes(keys)


def first_rows(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(m,) distinct keys in ascending order, and (m,) the first of the (n,) rows with each key."""
    distinct, first, _ = _native.groups(keys)
    return distinct, first


def group_maxima(keys: NDArray[np.int64], values: NDArray[np.floating]) -> NDArray[np.float64]:
    """(m,) largest of the (n,) values with each key, in ascending order of the keys."""
    if len(keys) == 0:
        return np.empty(0)
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    return np.maximum.reduceat(values[order], first)


@dataclass(frozen=True, eq=False)
class VoxelSums:
    """Sums of some columns for each voxel.

    Attributes:
        keys: (n,) int64, ascending and distinct.
        totals: (n, columns) float64.
    """

    keys: NDArray[np.int64]
    totals: NDArray[np.float64]

    @classmethod
    def empty(cls, columns: int) -> VoxelSums:
        """A table without voxels."""
        return cls(np.empty(0, np.int64), np.empty((0, columns)))

    @classmethod
    def from_rows(cls, keys: NDArray[np.int64], values: NDArray[np.floating]) -> VoxelSums:
        """Sum the rows with equal keys.

        Args:
            keys: (n,) in any order.
            values: (n, columns).
        """
        return cls(*_native.row_sums(keys, values))

    def __len__(self) -> int:
        return len(self.keys)

    def plus(self, *others: VoxelSums) -> VoxelSums:
        """The sum of all tables, bit for bit as if the others were added one by one."""
        if len(others) == 1:
            keys, totals = others[0].keys, others[0].totals
        else:
            keys = np.concatenate([self.keys[:0], *(other.keys for other in others)])
            order = np.argsort(keys, kind="stable")
            totals = np.concatenate([self.totals[:0], *(other.totals for other in others)])
            keys, totals = keys[order], totals[order]
        return VoxelSums(*_native.table_sum(self.keys, self.totals, keys, totals))

    def split_means(self, keys: NDArray[np.int64]) -> NDArray[np.float64]:
        """Split the mean of each voxel evenly among rows.

        The table has two columns, sum and count. The mean of a voxel is sum / count.

        Args:
            keys: (n,) one per row, in any order.

        Returns:
            (n,) the mean of each row's voxel, divided by the number of rows with that key; 0 for
            keys that are not in the table.

        Raises:
            ValueError: The table has not two columns.
        """
        return _native.split_means(self.keys, self.totals, keys)
