"""The model put together anew after a correction, while frames go on coming."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.geometry.voxel_sums import VoxelSums, group_maxima, voxel_keys
from circumspect.mapping import surface_area
from circumspect.mapping.frame_share import FRAMES, NORMAL, POINT, WEIGHT, FrameShare
from circumspect.mapping.object_model import ModelSettings, ObjectModel
from circumspect.mapping.object_views import FINE, ObjectViews, ViewPatch


class Rebuild:
    """Every patch where its keyframe is now, little by little, lest a frame waits for all.

    Attributes:
        model: What is put together so far.
    """

    def __init__(
        self,
        views: ObjectViews,
        settings: ModelSettings,
        voxel: float | None,
        place: Callable[[int], RigidTransform],
    ) -> None:
        """Begin.

        Args:
            views: The patches.
            settings: How frames are fused.
            voxel: Side of the model's voxels [m].
            place: Number of a keyframe to its `T_map_camera`; patches of keyframes that it
                raises KeyError for are left out.
        """
        self.model = ObjectModel(settings, voxel)
        self._allowed = 0
        self._waiting: deque[tuple[ViewPatch, RigidTransform]] = deque()
        for number, patch in views.patches.items():
            try:
                self._waiting.append((patch, composed(place(number), patch.T_anchor_patch)))
            except KeyError:  # the keyframe gave way so long ago that it is forgotten
                continue

    @property
    def is_whole(self) -> bool:
        """Whether all are in the model."""
        return not self._waiting

    def go_on(self, voxels: int | None = None) -> None:
        """Add patches.

        Args:
            voxels: So many may be added, beside those that were allowed before and are not yet;
                None means all.
        """
        self._allowed += voxels or 0
        while self._waiting and (voxels is None or len(self._waiting[0][0]) <= self._allowed):
            patch, T_map_patch = self._waiting[0]
            self.model = _with_patch(self.model, patch, T_map_patch)
            self._allowed -= len(patch)
            self._waiting.popleft()

    def with_share(self, share: FrameShare) -> None:
        """Add a frame that came since the beginning, at its corrected pose."""
        self.model = self.model.with_share(share)


def _with_patch(model: ObjectModel, patch: ViewPatch, T_map_patch: RigidTransform) -> ObjectModel:
    matrix = T_map_patch.as_matrix()
    R, t = matrix[:3, :3], matrix[:3, 3]
    rows = patch.sums.totals
    local = rows[:, POINT] / rows[:, WEIGHT, None]
    local_normals = rows[:, NORMAL] / rows[:, WEIGHT, None]
    points = local @ R.T + t
    columns = rows.copy()
    columns[:, POINT] = points * rows[:, WEIGHT, None]
    columns[:, NORMAL] = rows[:, NORMAL] @ R.T
    keys = voxel_keys(points, model.voxel or FINE)
    sums = VoxelSums.from_rows(keys, columns)
    # Two voxels of a patch may come to lie in one: it was seen in as many frames as either.
    sums.totals[:, FRAMES] = group_maxima(keys, rows[:, FRAMES])
    areas = surface_area.several_frames_areas(
        points,
        local_normals @ R.T,
        surface_area.point_areas(patch.areas, local, local_normals),
        len(patch.views_xyz),
    )
    ends = patch.rays.ends_xyz @ R.T.astype(np.float32) + t.astype(np.float32)
    origins = patch.rays.origins_xyz @ R.T.astype(np.float32) + t.astype(np.float32)
    return replace(
        model,
        areas=model.areas.plus(areas),
        rays=model.rays.with_rays(origins, ends, patch.rays.on_object),
        views_xyz=np.vstack([model.views_xyz, patch.views_xyz @ R.T + t]),
    ).with_sums(sums)
