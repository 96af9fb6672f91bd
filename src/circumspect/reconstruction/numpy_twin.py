"""NumPy twins of the kernels of reconstruction, written for clarity; the tests' reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.numpy_twin import row_sums


def surface_sums(
    points_xyz: NDArray[np.float64],
    normals_xyz: NDArray[np.float32],
    weights: NDArray[np.float32],
    keys: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Twin of `_native.surface_sums`."""
    weight = np.asarray(weights, np.float64)[:, None]
    unique, totals = row_sums(keys, np.hstack([weight, weight * points_xyz, weight * normals_xyz]))
    return unique, np.hstack([totals, np.ones((len(unique), 1))])


def surface_means(
    totals: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Twin of `_native.surface_means`."""
    normals = totals[:, 4:7]
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.where(lengths > 1e-9, normals / np.maximum(lengths, 1e-9), [0.0, 0.0, 1.0])
    return totals[:, 1:4] / totals[:, :1], unit
