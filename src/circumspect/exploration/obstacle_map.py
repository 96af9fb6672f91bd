"""Plan-view map of the obstacles that the camera observed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.planning.plan_view import cell_keys, cell_middles
from circumspect.sensing import RgbdFrame

CELL_M = 0.05
"""Side of the plan-view cells [m]."""
MIN_HEIGHT_M, MAX_HEIGHT_M = 0.10, 1.30
"""Points between these heights [m] are obstacles; lower ones may be noise of the floor."""
MAX_DEPTH_M = 2.5
"""Maximum depth that is used [m]."""
PIXEL_STEP = 6
"""One pixel of each block of this side is used [px]."""
MIN_FRAMES = 2
"""Minimum number of frames that show a point in an occupied cell."""
OBJECT_MARGIN_M = 0.12
"""Cells nearer than this to the object belong to it [m]."""


@dataclass(frozen=True, eq=False)
class ObstacleMap:
    """Plan-view cells with points, those of the object included.

    Attributes:
        keys: (c,) int64, ascending: the cells.
        frames: (c,) number of frames with points in each cell.
    """

    keys: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    frames: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))

    def with_frame(self, frame: RgbdFrame, T_map_camera: RigidTransform) -> ObstacleMap:
        """A map with one more frame.

        Args:
            frame: The frame.
            T_map_camera: Pose of the camera.
        """
        sparse = np.zeros(frame.depth.shape, bool)
        sparse[::PIXEL_STEP, ::PIXEL_STEP] = frame.depth[::PIXEL_STEP, ::PIXEL_STEP] < MAX_DEPTH_M
        points = frame.at(T_map_camera).points_map(sparse)
        points = points[(points[:, 2] > MIN_HEIGHT_M) & (points[:, 2] < MAX_HEIGHT_M)]
        found = np.unique(cell_keys(points[:, :2], CELL_M))
        keys, index = np.unique(np.concatenate([self.keys, found]), return_inverse=True)
        weights = np.concatenate([self.frames, np.ones(len(found), np.int64)])
        return ObstacleMap(keys, np.bincount(index, weights).astype(np.int64))

    def places_xy(self, object_xy: NDArray[np.floating]) -> NDArray[np.float64]:
        """The occupied cells without the object.

        Args:
            object_xy: (n, 2) [m] points of the object.

        Returns:
            (m, 2) [m] centres of cells.
        """
        places = cell_middles(self.keys[self.frames >= MIN_FRAMES], CELL_M)
        if len(object_xy) == 0 or len(places) == 0:
            return places
        from scipy.spatial import KDTree

        # Built for one query only.
        tree = KDTree(object_xy, balanced_tree=False, compact_nodes=False)
        away, _ = tree.query(places, distance_upper_bound=2 * OBJECT_MARGIN_M)
        return places[away > OBJECT_MARGIN_M]
