"""Pixels that hang in the air between an edge and what is behind it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing import _native
from circumspect.sensing.depth_noise import DepthNoise

SPREADS = 4 * float(np.sqrt(2))
"""Standard deviations of one depth that two neighbours may differ by: four of a difference."""


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
    image = np.ascontiguousarray(depth, np.float32)
    keep = np.empty(image.shape, bool)
    slope = float(np.tan(steepest)) / camera.fx
    _native.continuous(image, noise.coefficients(camera), SPREADS, slope, keep)
    return keep
