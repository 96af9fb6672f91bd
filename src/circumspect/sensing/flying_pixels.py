"""Pixels that hang in the air between an edge and what is behind it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing.depth_noise import DepthNoise


def continuous_pixels(
    depth: NDArray[np.floating], camera: PinholeCamera, noise: DepthNoise, steepest: float = 1.4
) -> NDArray[np.bool_]:
    """Pixels that lie on a surface.

    A pixel on a surface, its rim included, continues to at least one of its two neighbours
    along rows and along columns. A pixel between an edge and the background continues to none.

    Args:
        depth: (height, width) [m], NaN invalid.
        camera: The camera.
        noise: Its noise; differences within four standard deviations are no jump.
        steepest: Surfaces seen at more than this angle [rad] count as jumps.

    Returns:
        (height, width) bool; False where the depth is invalid.
    """
    keep = np.isfinite(depth)
    spread = 4 * float(np.sqrt(2)) * noise.axial_sigma(depth) + noise.quantisation_step(
        depth, camera
    )
    allowed = np.maximum(spread, depth * np.float32(np.tan(steepest) / camera.fx))
    for axis in (0, 1):
        along, limit = np.moveaxis(depth, axis, 0), np.moveaxis(allowed, axis, 0)
        with np.errstate(invalid="ignore"):
            joined = np.abs(np.diff(along, axis=0)) <= np.minimum(limit[1:], limit[:-1])
        either = np.zeros(along.shape, bool)
        either[1:] |= joined
        either[:-1] |= joined
        keep &= np.moveaxis(either, 0, axis)
    return keep
