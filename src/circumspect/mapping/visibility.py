"""Whether a frame looks through what is known to be there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
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
AWAY = 6
"""So far [px] are the pixels that count as round it: rims are no contradiction."""
ROUND_IT = ((0, 0), (-AWAY, 0), (AWAY, 0), (0, -AWAY), (0, AWAY))
NEAREST, FARTHEST = 0.5, 3.0
"""Range [m] within which points should be seen well."""


def seen_through(
    frame: RgbdFrame,
    scene: SceneMap,
    T_map_camera: RigidTransform,
    phantoms: NDArray[np.int64] | None = None,
) -> float:
    """Share of the map's points in view and off the floor that the frame looks through.

    A frame taken from elsewhere than believed shows free space where the map has surfaces. What
    hides a point of the map is no contradiction: the scene may hold more than the map.

    Args:
        frame: The frame.
        scene: The map.
        T_map_camera: Where the frame is believed to be taken from.
        phantoms: Keys of the map's points that do not count, ascending; see `phantoms_of`.

    Returns:
        0 where no point is in view.
    """
    standing = _standing(scene)
    chosen = standing[:: max(1, len(standing) // SAMPLE)]
    if phantoms is not None and len(phantoms):
        chosen = chosen[~_among(scene.sums.keys[chosen], phantoms)]
    _, through, seen = _looked_at(frame, scene, T_map_camera, chosen)
    counted = int(through.sum()), int(seen.sum())
    return counted[0] / sum(counted) if sum(counted) >= FEWEST else 0.0


def phantoms_of(
    frame: RgbdFrame, scene: SceneMap, T_map_camera: RigidTransform
) -> NDArray[np.int64]:
    """Keys of the map's points that a frame looks through from where it surely was, ascending.

    A point of the map is the mean over a voxel: of a chair's rungs some lie in between.

    Args:
        frame: A keyframe, whose scan is in the map.
        scene: The map.
        T_map_camera: Where it was taken from.
    """
    indices, through, _ = _looked_at(frame, scene, T_map_camera, _standing(scene))
    return scene.sums.keys[np.sort(indices[through])]


def _standing(scene: SceneMap) -> NDArray[np.intp]:
    return np.flatnonzero(np.abs(scene.points_xyz[:, 2]) > FLOOR)


def _among(keys: NDArray[np.int64], known: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which keys are among known ones, ascending and at least one."""
    places = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return known[places] == keys


def _looked_at(
    frame: RgbdFrame, scene: SceneMap, T_map_camera: RigidTransform, chosen: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.bool_], NDArray[np.bool_]]:
    """Those of the map's points that are in view, and which are looked through, and seen."""
    matrix, camera = T_map_camera.as_matrix(), frame.camera
    points = (scene.points_xyz[chosen] - matrix[:3, 3]) @ matrix[:3, :3]
    facing = np.einsum("ij,ij->i", points, scene.normals_xyz[chosen] @ matrix[:3, :3]) < 0
    near = facing & (points[:, 2] > NEAREST) & (points[:, 2] < FARTHEST)
    chosen, points = chosen[near], points[near]
    x, y, z = points.T
    u = np.rint(x / z * camera.fx + camera.cx).astype(np.intp)
    v = np.rint(y / z * camera.fy + camera.cy).astype(np.intp)
    inside = (u >= AWAY) & (u < camera.width - AWAY) & (v >= AWAY) & (v < camera.height - AWAY)
    chosen, u, v, z = chosen[inside], u[inside], v[inside], z[inside]
    around = np.stack([frame.depth[v + dv, u + du] for dv, du in ROUND_IT])
    measured = np.isfinite(around).all(axis=0)
    chosen, around, z = chosen[measured], around[:, measured], z[measured]
    return chosen, around.min(axis=0) > z + SLACK, np.abs(around[0] - z) <= SLACK
