"""What stands about besides the object, as far as the camera saw it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.planning.plan_view import cell_keys, cell_middles
from circumspect.sensing import RgbdFrame

CELL = 0.05
"""Side of the plan-view cells [m]."""
LOWEST, HIGHEST = 0.10, 1.30
"""What is between these heights is in a robot's way [m]; lower may be noise of the floor."""
FARTHEST = 2.5
"""Only depths up to this are used [m]."""
EVERY = 6
"""One pixel of so many, along rows and columns."""
FEWEST_FRAMES = 2
"""A cell is taken when so many frames had something there."""
BESIDE = 0.12
"""What is this near to the object belongs to it [m]."""


@dataclass(frozen=True, eq=False)
class ObstacleMap:
    """Plan-view cells in which something stood, object included; `with_frame` returns a new one.

    Attributes:
        keys: (c,) int64, ascending: the cells.
        frames: (c,) how many frames had something there.
    """

    keys: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    frames: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))

    def with_frame(self, frame: RgbdFrame, T_map_camera: RigidTransform) -> ObstacleMap:
        """The map with one more frame.

        Args:
            frame: The frame.
            T_map_camera: Where it was taken from.
        """
        sparse = np.zeros(frame.depth.shape, bool)
        sparse[::EVERY, ::EVERY] = frame.depth[::EVERY, ::EVERY] < FARTHEST
        points = frame.at(T_map_camera).points_map(sparse)
        points = points[(points[:, 2] > LOWEST) & (points[:, 2] < HIGHEST)]
        found = np.unique(cell_keys(points[:, :2], CELL))
        keys, index = np.unique(np.concatenate([self.keys, found]), return_inverse=True)
        weights = np.concatenate([self.frames, np.ones(len(found), np.int64)])
        return ObstacleMap(keys, np.bincount(index, weights).astype(np.int64))

    def places_xy(self, object_xy: NDArray[np.floating]) -> NDArray[np.float64]:
        """Where something stands that is not the object.

        Args:
            object_xy: (n, 2) [m] what is known of the object.

        Returns:
            (m, 2) [m] middles of cells.
        """
        places = cell_middles(self.keys[self.frames >= FEWEST_FRAMES], CELL)
        if len(object_xy) == 0 or len(places) == 0:
            return places
        from scipy.spatial import KDTree

        # Built for one look only.
        tree = KDTree(object_xy, balanced_tree=False, compact_nodes=False)
        away, _ = tree.query(places, distance_upper_bound=2 * BESIDE)
        return places[away > BESIDE]
