"""Free-space violations: map points in space that a frame shows as free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M
from circumspect.registration.surface_map import SurfaceMap
from circumspect.sensing import RgbdFrame

SAMPLE_SIZE = 4000
"""`violation_ratio` tests about this many points of the map."""
MIN_POINTS_IN_VIEW = 50
"""With fewer points in view the ratio is 0."""
MIN_VIOLATION_DEPTH_M = 0.06
"""A map point is violated if the frame is free for more than this [m] behind it."""
RIM_PX = 6
"""The frame must be free as well at pixels in this distance [px]. Rims are no violations."""
NEIGHBOUR_OFFSETS_PX = ((0, 0), (-RIM_PX, 0), (RIM_PX, 0), (0, -RIM_PX), (0, RIM_PX))
MIN_DEPTH_M, MAX_DEPTH_M = 0.5, 3.0
"""Only map points at depths in this range [m] are tested."""


def violation_ratio(
    frame: RgbdFrame,
    surface_map: SurfaceMap,
    T_map_camera: RigidTransform,
    ignored_keys: NDArray[np.int64] | None = None,
) -> float:
    """Fraction of the map points in view, off the floor, that violate the frame's free space.

    A frame at a wrong pose shows free space where the map has surfaces. A map point that is
    occluded is no violation: the scene may contain more than the map.

    Args:
        frame: The frame.
        surface_map: The map.
        T_map_camera: Pose of the frame.
        ignored_keys: Ascending keys of map points that do not count; see `violated_points`.

    Returns:
        The ratio of violated points to violated and observed ones; 0 if there are fewer than
        `MIN_POINTS_IN_VIEW`.
    """
    off_floor = _points_off_floor(surface_map)
    sample = off_floor[:: max(1, len(off_floor) // SAMPLE_SIZE)]
    if ignored_keys is not None and len(ignored_keys):
        sample = sample[~_contained(surface_map.sums.keys[sample], ignored_keys)]
    _, violated, observed = _compared(frame, surface_map, T_map_camera, sample)
    counts = int(violated.sum()), int(observed.sum())
    return counts[0] / sum(counts) if sum(counts) >= MIN_POINTS_IN_VIEW else 0.0


def violated_count(
    frame: RgbdFrame,
    surface_map: SurfaceMap,
    T_map_camera: RigidTransform,
    ignored_keys: NDArray[np.int64],
    sample_size: int = SAMPLE_SIZE,
) -> float:
    """Number of map points in view, off the floor, that violate the frame's free space.

    Args:
        frame: The frame.
        surface_map: The map.
        T_map_camera: Pose of the frame.
        ignored_keys: Ascending keys of map points that do not count; see `violated_points`.
        sample_size: The number is estimated from so many points.
    """
    off_floor = _points_off_floor(surface_map)
    step = max(1, len(off_floor) // sample_size)
    sample = off_floor[::step]
    if len(ignored_keys):
        sample = sample[~_contained(surface_map.sums.keys[sample], ignored_keys)]
    _, violated, _ = _compared(frame, surface_map, T_map_camera, sample)
    return float(step * violated.sum())


def violated_points(
    frame: RgbdFrame, surface_map: SurfaceMap, T_map_camera: RigidTransform
) -> NDArray[np.int64]:
    """Keys of the map points that violate the free space of a frame with a reliable pose.

    Such map points are artefacts. A map point is the mean over a voxel, and between the rungs of a
    chair some means lie in free space.

    Args:
        frame: A keyframe whose scan is in the map.
        surface_map: The map.
        T_map_camera: Pose of the frame.

    Returns:
        Ascending keys of `surface_map.sums`.
    """
    indices, violated, _ = _compared(
        frame, surface_map, T_map_camera, _points_off_floor(surface_map)
    )
    return surface_map.sums.keys[np.sort(indices[violated])]


def _points_off_floor(surface_map: SurfaceMap) -> NDArray[np.intp]:
    return np.flatnonzero(np.abs(surface_map.points_xyz[:, 2]) > MAX_FLOOR_HEIGHT_M)


def _contained(keys: NDArray[np.int64], known_keys: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each key is one of the known keys, which are ascending and at least one."""
    places = np.minimum(np.searchsorted(known_keys, keys), len(known_keys) - 1)
    return known_keys[places] == keys


def _compared(
    frame: RgbdFrame,
    surface_map: SurfaceMap,
    T_map_camera: RigidTransform,
    indices: NDArray[np.intp],
) -> tuple[NDArray[np.intp], NDArray[np.bool_], NDArray[np.bool_]]:
    """Those of the map points that are in view; whether each is violated, and is observed."""
    matrix, camera = T_map_camera.as_matrix(), frame.camera
    points = (surface_map.points_xyz[indices] - matrix[:3, 3]) @ matrix[:3, :3]
    normals = surface_map.normals_xyz[indices] @ matrix[:3, :3]
    facing = np.einsum("ij,ij->i", points, normals) < 0
    in_range = facing & (points[:, 2] > MIN_DEPTH_M) & (points[:, 2] < MAX_DEPTH_M)
    indices, points = indices[in_range], points[in_range]
    x, y, z = points.T
    u = np.rint(x / z * camera.fx + camera.cx).astype(np.intp)
    v = np.rint(y / z * camera.fy + camera.cy).astype(np.intp)
    columns = (u >= RIM_PX) & (u < camera.width - RIM_PX)
    inside = columns & (v >= RIM_PX) & (v < camera.height - RIM_PX)
    indices, u, v, z = indices[inside], u[inside], v[inside], z[inside]
    depths = np.stack([frame.depth[v + dv, u + du] for dv, du in NEIGHBOUR_OFFSETS_PX])
    measured = np.isfinite(depths).all(axis=0)
    indices, depths, z = indices[measured], depths[:, measured], z[measured]
    violated = depths.min(axis=0) > z + MIN_VIOLATION_DEPTH_M
    return indices, violated, np.abs(depths[0] - z) <= MIN_VIOLATION_DEPTH_M
