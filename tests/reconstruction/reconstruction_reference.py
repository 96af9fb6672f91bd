"""NumPy twins of the kernels of reconstruction, written for clarity; the tests' reference."""

from __future__ import annotations

import numpy as np
from groups_reference import row_sums
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthBlocks


def frame_surface(
    depth: NDArray[np.float32],
    mask: NDArray[np.bool_],
    camera: tuple[float, float, float, float],
    pose: NDArray[np.float64],
    noise: tuple[float, float, float, float],
    point_block: int,
    normal_block: int,
    jump: float,
    min_incidence_cosine: float,
) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Twin of `_native.frame_surface`."""
    fx, fy, cx, cy = camera
    height, width = depth.shape
    pinhole = PinholeCamera(width, height, fx, fy, cx, cy)
    fine = DepthBlocks.of(depth, pinhole, point_block, mask, jump)
    coarse = DepthBlocks.of(depth, pinhole, normal_block, mask, jump)
    rows, columns = np.nonzero(fine.counts)
    points = fine.points_xyz(rows, columns).astype(np.float64)
    ratio = normal_block // point_block
    normals = coarse.normals()[rows // ratio, columns // ratio]
    towards = -points / np.linalg.norm(points, axis=1, keepdims=True)
    normals = np.where(np.isfinite(normals[:, :1]), normals, towards)
    cosine = np.maximum(np.einsum("ij,ij->i", normals, towards), min_incidence_cosine)
    z = points[:, 2]
    # The area of a pixel perpendicular to its ray shrinks with the ray's angle to the axis.
    facing = -towards[:, 2] * z**2 / (fx * fy) * fine.counts[rows, columns]
    a, b, c, _ = noise
    weights = cosine / (a + b * (z - c) ** 2) ** 2
    R, t = pose[:3, :3], pose[:3, 3]
    normals, areas = (normals @ R.T).astype(np.float32), (facing / cosine).astype(np.float32)
    return points @ R.T + t, normals, areas, weights.astype(np.float32)


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


def added_keys(known: NDArray[np.int64], keys: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Twin of `_native.added_keys`."""
    if not np.isin(known, keys).all():
        return None
    return np.flatnonzero(~np.isin(keys, known))
