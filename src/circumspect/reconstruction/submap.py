"""A submap: the object as observed by the frames near one keyframe."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.voxel_sums import VoxelSums
from circumspect.reconstruction import surface_area
from circumspect.reconstruction.compact_sums import CompactSums
from circumspect.reconstruction.frame_contribution import COLUMNS, FrameContribution
from circumspect.reconstruction.sight_rays import SightRays

MAX_PENDING_FRAMES = 8
"""Sums of this many frames are kept apart before they are added to the submap at once."""


@dataclass(frozen=True, eq=False)
class Submap:
    """The contributions of the frames near one keyframe, in the submap's own frame.

    Attributes:
        T_keyframe_submap: Pose of the submap frame in the keyframe's. The submap frame is the map
            frame at the time of the first contribution, so that contributions need no transform
            until the keyframe is corrected.
        compact: Sums per voxel, without the pending ones.
        areas: Area and frame count per surface patch; see `surface_area`.
        rays: Rays that hit the object or pass close to it.
        views_xyz: (f, 3) [m] camera positions.
        pending: Sums of the latest frames.
    """

    T_keyframe_submap: RigidTransform
    compact: CompactSums
    areas: VoxelSums = field(default_factory=lambda: VoxelSums.empty(surface_area.COLUMNS))
    rays: SightRays = field(default_factory=SightRays.empty)
    views_xyz: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    pending: tuple[VoxelSums, ...] = ()

    @classmethod
    def empty(cls, T_keyframe_submap: RigidTransform, centre_xyz: NDArray[np.floating]) -> Submap:
        """A submap without frames.

        Args:
            T_keyframe_submap: Pose of the submap frame.
            centre_xyz: (3,) [m] about the position of the first camera, submap frame.
        """
        return cls(T_keyframe_submap, CompactSums.from_sums(VoxelSums.empty(COLUMNS), centre_xyz))

    def __len__(self) -> int:
        """Upper bound of the number of voxels; pending frames are counted separately."""
        return len(self.compact.keys) + sum(map(len, self.pending))

    @property
    def sums(self) -> VoxelSums:
        """Sums per voxel over all frames."""
        expanded = self.compact.expanded()
        return expanded.plus(*self.pending) if self.pending else expanded

    def with_contribution(self, local: FrameContribution) -> Submap:
        """The submap with the contribution of one more frame.

        Args:
            local: The contribution, submap frame.
        """
        origin_xyz = local.surface.origin_xyz
        submap = replace(
            self,
            areas=self.areas.plus(local.areas),
            rays=self.rays.with_frame(origin_xyz, local.ends_xyz, local.on_object),
            views_xyz=np.vstack([self.views_xyz, origin_xyz]),
            pending=(*self.pending, local.sums),
        )
        return submap.compacted() if len(submap.pending) >= MAX_PENDING_FRAMES else submap

    def compacted(self) -> Submap:
        """The submap without pending sums, in the least memory."""
        if not self.pending:
            return self
        compact = CompactSums.from_sums(self.sums, self.compact.centre_xyz)
        return replace(self, compact=compact, pending=())
