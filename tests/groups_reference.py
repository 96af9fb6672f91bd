"""NumPy twins of the kernels for keys and sums, written for clarity; the tests' reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def groups(
    keys: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Twin of `_native.groups`."""
    unique, first, of_row = np.unique(keys, return_index=True, return_inverse=True)
    return unique, first, of_row


def group_sizes(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Twin of `_native.group_sizes`."""
    _, of_row, counts = np.unique(keys, return_inverse=True, return_counts=True)
    return counts[of_row]


def split_means(
    table_keys: NDArray[np.int64], totals: NDArray[np.float64], keys: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Twin of `_native.split_means`."""
    means = dict(zip(table_keys.tolist(), totals[:, 0] / totals[:, 1], strict=True))
    return np.array([means.get(key, 0.0) for key in keys.tolist()]) / group_sizes(keys)


def row_sums(
    keys: NDArray[np.int64], values: NDArray[np.floating]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Twin of `_native.row_sums`."""
    unique, of_row = np.unique(keys, return_inverse=True)
    totals = np.zeros((len(unique), values.shape[1]))
    np.add.at(totals, of_row, values)
    return unique, totals


def table_sum(
    one_keys: NDArray[np.int64],
    one: NDArray[np.float64],
    other_keys: NDArray[np.int64],
    other: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Twin of `_native.table_sum`."""
    return row_sums(np.concatenate([one_keys, other_keys]), np.concatenate([one, other]))


def packed_cells(
    points_xyz: NDArray[np.floating], side: float, bits: int, offset: int
) -> NDArray[np.int64]:
    """Twin of `_native.packed_cells`."""
    cells = np.floor(points_xyz / side).astype(np.int64) + offset
    cells &= (1 << bits) - 1
    return (cells[:, 0] << (2 * bits)) | (cells[:, 1] << bits) | cells[:, 2]


def patch_keys(cells: NDArray[np.int64], normals_xyz: NDArray[np.floating]) -> NDArray[np.int64]:
    """Twin of `_native.patch_keys`."""
    axis = np.abs(normals_xyz).argmax(axis=1)
    ahead = np.take_along_axis(normals_xyz, axis[:, None], axis=1)[:, 0] > 0
    return cells * 8 + (2 * axis + ahead)
