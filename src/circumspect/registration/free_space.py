"""Free space in front of the camera, and map points that violate it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M
from circumspect.registration.surface_map import SurfaceMap
from circumspect.sensing import RgbdFrame

BLOCK_PX = 8
"""Depths are reduced over square blocks of this side [px]."""
MIN_VALID_FRACTION = 0.9
"""A block with a smaller fraction of valid pixels is unknown."""
MARGIN_M, MARGIN_GROWTH_PER_M = 0.06, 0.01
"""Points are free if they are in front of a surface by more than the margin [m] plus the growth
[1/m] times the squared depth. Poses have small errors, and depth noise grows with squared depth."""
SAMPLE_SIZE = 4000
"""`violation_ratio` tests about this many points of the map."""
MIN_POINTS_IN_VIEW = 50
"""With fewer points in view the ratio is 0."""
MIN_VIOLATION_DEPTH_M = 0.06
"""A map point is violated if the frame is free for more than this [m] behind it."""
RIM_PX = 6
"""The frame must also be free at pixels at this distance [px], so that rims are no violations."""
NEIGHBOUR_OFFSETS_PX = ((0, 0), (-RIM_PX, 0), (RIM_PX, 0), (0, -RIM_PX), (0, RIM_PX))
MIN_DEPTH_M, MAX_DEPTH_M = 0.5, 3.0
"""Only map points at depths in this range [m] are tested."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Lower bound of the free depth in each direction of a frame.

    Attributes:
        free_depth: (rows, columns) float32 [m] smallest depth in a block of pixels and its
            neighbours; 0 if one of them is unknown.
        camera: The camera of the whole frame.
    """

    free_depth: NDArray[np.float32]
    camera: PinholeCamera

    @classmethod
    def from_frame(cls, frame: RgbdFrame) -> FreeSpace:
        """Compute the free space of a frame."""
        rows, columns = frame.camera.height // BLOCK_PX, frame.camera.width // BLOCK_PX
        cut = frame.depth[: rows * BLOCK_PX, : columns * BLOCK_PX]
        # Rows first: whole lines of the image are quick to reduce.
        lines = cut.reshape(rows, BLOCK_PX, columns * BLOCK_PX)
        measured = np.isfinite(lines).sum(axis=1, dtype=np.int32)
        counts = measured.reshape(rows, columns, BLOCK_PX).sum(axis=2)
        valid = counts >= MIN_VALID_FRACTION * BLOCK_PX**2
        line = np.fmin.reduce(lines, axis=1).reshape(rows, columns, BLOCK_PX)
        smallest = np.where(valid, np.fmin.reduce(line, axis=2), 0)
        return cls(
            ndimage.minimum_filter(smallest, 3, mode="nearest").astype(np.float32), frame.camera
        )

    def contains(self, points_xyz: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Whether points lie in free space.

        Args:
            points_xyz: (n, 3) [m] optical frame.

        Returns:
            (n,); False for points out of view.
        """
        depth, free = points_xyz[:, 2], self._free_depth_towards(points_xyz)
        return (free > 0) & (depth + MARGIN_M + MARGIN_GROWTH_PER_M * depth**2 < free)

    def agrees_with(self, points_xyz: NDArray[np.floating], tolerance: float) -> NDArray[np.bool_]:
        """Whether points lie at the depth where free space ends.

        Args:
            points_xyz: (n, 3) [m] optical frame.
            tolerance: Largest difference of the depths [m].

        Returns:
            (n,); False for points out of view.
        """
        free = self._free_depth_towards(points_xyz)
        return (free > 0) & (np.abs(points_xyz[:, 2] - free) < tolerance)

    def _free_depth_towards(self, points_xyz: NDArray[np.floating]) -> NDArray[np.float64]:
        """(n,) [m] `free_depth` in the directions of points; 0 out of view."""
        x, y, z = points_xyz.T
        in_front = z > 1e-6
        depth = np.where(in_front, z, 1.0)
        column = (x / depth * self.camera.fx + self.camera.cx) // BLOCK_PX
        row = (y / depth * self.camera.fy + self.camera.cy) // BLOCK_PX
        rows, columns = self.free_depth.shape
        inside = in_front & (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        free = np.zeros(len(points_xyz))
        free[inside] = self.free_depth[row[inside].astype(np.intp), column[inside].astype(np.intp)]
        return free


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
        sample_size: Number of points from which it is estimated.
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
    """Map points in view, and whether each is violated and whether it is observed."""
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
