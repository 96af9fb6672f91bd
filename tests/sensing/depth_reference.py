"""NumPy twins of the native kernels of sensing, written for clarity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_plane import FloorPlane
from circumspect.sensing.pixel_rays import along_axis
from circumspect.sensing.rgbd_frame import RgbdFrame


def block_means(
    depth: NDArray[np.floating], block: int, mask: NDArray[np.bool_] | None, jump: float
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Twin of the sums in `DepthBlocks.of`."""
    valid = np.isfinite(depth) & (depth > 0) & (True if mask is None else mask)
    height, width = depth.shape
    rows, columns = -(-height // block), -(-width // block)
    inverse = np.full((rows * block, columns * block), np.nan)
    inverse[:height, :width][valid] = 1 / np.asarray(depth, np.float64)[valid]
    cells = inverse.reshape(rows, block, columns, block).swapaxes(1, 2).reshape(rows, columns, -1)
    counts = np.isfinite(cells).sum(axis=2).astype(np.int32)
    highest = np.nan_to_num(cells, nan=0.0).max(axis=2)
    lowest = np.nan_to_num(cells, nan=np.inf).min(axis=2)
    counts[(counts > 0) & (highest - lowest > 2 * jump * highest)] = 0
    mean = np.full((rows, columns), np.nan, np.float32)
    total = np.nan_to_num(cells, nan=0.0).sum(axis=2)
    np.divide(total, counts, out=mean, where=counts > 0, casting="same_kind")
    return mean, counts


def continuous_pixels(
    depth: NDArray[np.floating], camera: PinholeCamera, noise: DepthNoise, max_incidence: float
) -> NDArray[np.bool_]:
    """Twin of `flying_pixels.continuous_pixels`."""
    keep = np.isfinite(depth)
    spread = 4 * np.sqrt(2) * noise.axial_sigma(depth) + noise.quantisation_step(depth, camera)
    allowed = np.maximum(spread, depth * np.float32(np.tan(max_incidence) / camera.fx))
    for axis in (0, 1):
        along, limit = np.moveaxis(depth, axis, 0), np.moveaxis(allowed, axis, 0)
        joined = np.abs(np.diff(along, axis=0)) <= np.minimum(limit[1:], limit[:-1])
        either = np.zeros(along.shape, bool)
        either[1:] |= joined
        either[:-1] |= joined
        keep &= np.moveaxis(either, 0, axis)
    return keep


def clearance(
    frame: RgbdFrame, floor: FloorPlane, noise: DepthNoise
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Each pixel's height above the floor [m], and the standard deviation of that."""
    up = np.array([-floor.slope_x, -floor.slope_y, 1.0])
    matrix = frame.pose.as_matrix()
    rise = along_axis(frame.camera, matrix[:3, :3].T @ up)
    height = frame.depth * rise + np.float32(up @ matrix[:3, 3] - floor.offset)
    step = noise.quantisation_step(frame.depth, frame.camera)
    sigma = np.abs(rise) * np.sqrt(noise.axial_sigma(frame.depth) ** 2 + step**2 / 12)
    return height, sigma


def plan_places(
    frame: RgbdFrame, mask: NDArray[np.bool_], cell: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 2) places of the masked pixels in cells of the plan, and (2,) [m] where those begin."""
    points = frame.points_map(mask)[:, :2]
    low = points.min(axis=0) - 2 * cell
    return (points - low) / cell, low
