"""Rays of the pixels of a camera, computed once per camera."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera


@lru_cache(maxsize=4)
def pixel_rays(camera: PinholeCamera) -> NDArray[np.float32]:
    """(height, width, 3) float32, read-only: the point at depth 1 m on the ray of each pixel."""
    rays = np.ascontiguousarray(camera.rays_xyz, dtype=np.float32)
    rays.flags.writeable = False
    return rays


def along_axis(camera: PinholeCamera, axis_xyz: NDArray[np.floating]) -> NDArray[np.float32]:
    """(height, width): length along `axis_xyz` of each pixel's ray, per metre of depth."""
    x, y, z = np.asarray(axis_xyz, dtype=np.float32)
    u = (np.arange(camera.width, dtype=np.float32) - camera.cx) / camera.fx
    v = (np.arange(camera.height, dtype=np.float32) - camera.cy) / camera.fy
    return ((x * u + z)[None, :] + (y * v)[:, None]).astype(np.float32)
