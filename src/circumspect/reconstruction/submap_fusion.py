"""Fusion of submaps into a new model after a correction of the keyframes, in small steps."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.geometry.voxel_sums import VoxelSums, group_maxima, voxel_keys
from circumspect.reconstruction import surface_area
from circumspect.reconstruction.frame_contribution import (
    FRAMES,
    NORMAL,
    POINT,
    WEIGHT,
    FrameContribution,
)
from circumspect.reconstruction.object_model import ModelSettings, ObjectModel
from circumspect.reconstruction.submap import Submap, SubmapCollection

DEFAULT_VOXEL_M = 0.01
"""Side of the voxels if neither settings nor frames determine it [m]."""


class SubmapFusion:
    """Fuses submaps at the current poses of their keyframes into a new model.

    The work is split into steps (`fuse_pending`), so that no frame waits for all of it.

    Attributes:
        model: The model fused so far.
    """

    def __init__(
        self,
        submaps: SubmapCollection,
        settings: ModelSettings,
        voxel: float | None,
        keyframe_pose: Callable[[int], RigidTransform],
    ) -> None:
        """Start with all submaps pending.

        Args:
            submaps: The submaps.
            settings: Settings of the model.
            voxel: Side of the model's voxels [m].
            keyframe_pose: Returns `T_map_camera` of a keyframe by its number. Submaps of keyframes
                for which it raises KeyError are left out.
        """
        self.model = ObjectModel(settings, voxel)
        self._budget = 0
        self._pending: deque[tuple[Submap, RigidTransform]] = deque()
        for number, submap in submaps.submaps.items():
            try:
                T_map_submap = composed(keyframe_pose(number), submap.T_keyframe_submap)
            except KeyError:  # the keyframe was culled too long ago
                continue
            self._pending.append((submap, T_map_submap))

    @property
    def is_complete(self) -> bool:
        """Whether all submaps are in the model."""
        return not self._pending

    def fuse_pending(self, voxels: int | None = None) -> None:
        """Fuse pending submaps, each as a whole.

        Args:
            voxels: Number of voxels to fuse. Unused voxels of earlier calls are added to it. None
                fuses all submaps.
        """
        self._budget += voxels or 0
        while self._pending and (voxels is None or len(self._pending[0][0]) <= self._budget):
            submap, T_map_submap = self._pending[0]
            self.model = _with_submap(self.model, submap, T_map_submap)
            self._budget -= len(submap)
            self._pending.popleft()

    def add_contribution(self, contribution: FrameContribution) -> None:
        """Add a frame that arrived after the start.

        Args:
            contribution: The contribution at the frame's corrected pose, map frame.
        """
        self.model = self.model.with_contribution(contribution)


def _with_submap(model: ObjectModel, submap: Submap, T_map_submap: RigidTransform) -> ObjectModel:
    matrix = T_map_submap.as_matrix()
    R, t = matrix[:3, :3], matrix[:3, 3]
    rows = submap.sums.totals
    local = rows[:, POINT] / rows[:, WEIGHT, None]
    local_normals = rows[:, NORMAL] / rows[:, WEIGHT, None]
    points = local @ R.T + t
    columns = rows.copy()
    columns[:, POINT] = points * rows[:, WEIGHT, None]
    columns[:, NORMAL] = rows[:, NORMAL] @ R.T
    keys = voxel_keys(points, model.voxel or DEFAULT_VOXEL_M)
    sums = VoxelSums.from_rows(keys, columns)
    # Two voxels of a submap may fall into one. Its frame count is the larger of theirs.
    sums.totals[:, FRAMES] = group_maxima(keys, rows[:, FRAMES])
    areas = surface_area.multi_frame_areas(
        points,
        local_normals @ R.T,
        surface_area.point_areas(submap.areas, local, local_normals),
        len(submap.views_xyz),
    )
    ends = submap.rays.ends_xyz @ R.T.astype(np.float32) + t.astype(np.float32)
    origins = submap.rays.origins_xyz @ R.T.astype(np.float32) + t.astype(np.float32)
    return replace(
        model,
        areas=model.areas.plus(areas),
        rays=model.rays.with_rays(origins, ends, submap.rays.on_object),
        views_xyz=np.vstack([model.views_xyz, submap.views_xyz @ R.T + t]),
    ).with_sums(sums)
