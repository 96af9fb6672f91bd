"""Whether a frame looks through what is known to be there."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.scan_surface import FLOOR
from circumspect.mapping.scene_map import SceneMap
from circumspect.sensing import RgbdFrame

SAMPLE = 4000
"""So many points of the map are looked at."""
FEWEST = 50
"""Fewer points in view say nothing."""
SLACK = 0.06
"""Depths this much [m] beyond a point of the map, all round it, look through it."""
ROUND_IT = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
"""Where the pixels that count as round it lie, in parts of `AWAY`."""
AWAY, LEAST_AWAY = 0.02, 6
"""So far [m], and at least so many pixels, they are from it. Rims are no contradiction, nor are
thin parts: a point of the map, the mean over a voxel, may lie between the rungs of a chair."""
NEAREST, FARTHEST = 0.5, 3.0
"""Range [m] within which points should be seen well."""


def seen_through(frame: RgbdFrame, scene: SceneMap, T_map_camera: RigidTransform) -> float:
    """Share of the map's points in view and off the floor that the frame looks through.

    A frame taken from elsewhere than believed shows free space where the map has surfaces. What
    hides a point of the map is no contradiction: the scene may hold more than the map.

    Args:
        frame: The frame.
        scene: The map.
        T_map_camera: Where the frame is believed to be taken from.

    Returns:
        0 where no point is in view.
    """
    standing = np.flatnonzero(np.abs(scene.points_xyz[:, 2]) > FLOOR)
    chosen = standing[:: max(1, len(standing) // SAMPLE)]
    matrix, camera = T_map_camera.as_matrix(), frame.camera
    points = (scene.points_xyz[chosen] - matrix[:3, 3]) @ matrix[:3, :3]
    facing = np.einsum("ij,ij->i", points, scene.normals_xyz[chosen] @ matrix[:3, :3]) < 0
    points = points[facing & (points[:, 2] > NEAREST) & (points[:, 2] < FARTHEST)]
    x, y, z = points.T
    u = np.rint(x / z * camera.fx + camera.cx).astype(np.intp)
    v = np.rint(y / z * camera.fy + camera.cy).astype(np.intp)
    away = np.maximum(LEAST_AWAY, np.rint(AWAY * camera.fx / z).astype(np.intp))
    inside = (u >= away) & (u < camera.width - away) & (v >= away) & (v < camera.height - away)
    u, v, z, away = u[inside], v[inside], z[inside], away[inside]
    around = np.stack([frame.depth[v + dv * away, u + du * away] for dv, du in ROUND_IT])
    measured = np.isfinite(around).all(axis=0)
    nearest = around[:, measured].min(axis=0) if measured.any() else np.empty(0)
    z = z[measured]
    through = int((nearest > z + SLACK).sum())
    seen = int((np.abs(around[0, measured] - z) <= SLACK).sum())
    return through / (through + seen) if through + seen >= FEWEST else 0.0
