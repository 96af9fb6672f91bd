"""Submaps: the object as observed by the frames near one keyframe each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.geometry.voxel_sums import VoxelSums
from circumspect.reconstruction import surface_area
from circumspect.reconstruction.frame_contribution import (
    COLUMNS,
    NORMAL,
    POINT,
    WEIGHT,
    FrameContribution,
)
from circumspect.reconstruction.sight_rays import SightRays

MAX_PENDING_FRAMES = 8
"""Number of frames whose sums are collected before they are added to the submap."""
MAX_SUBMAPS = 300
"""Maximum number of submaps; beyond it, the one with the fewest frames is removed."""
MAX_SUBMAP_FRAMES = 40
"""Maximum number of frames per submap. The noise of more would keep adding voxels."""
UNCORRECTED_TOLERANCE = 1e-9
"""A keyframe pose is uncorrected if no matrix entry differs by this much."""


@dataclass(frozen=True, eq=False)
class CompactSums:
    """The sums of a `FrameContribution` in half the memory.

    Means are stored in place of sums, because rounding errors of sums accumulate over frames.
    Points are stored relative to a nearby centre: single precision resolves 0.2 µm at 3 m, but only
    a centimetre at 100 km.

    Attributes:
        keys: (n,) int64 voxel keys.
        means: (n, columns) float32 in the columns of a `FrameContribution`: weight, mean point
            relative to the centre, mean normal, frames.
        centre_xyz: (3,) [m].
    """

    keys: NDArray[np.int64]
    means: NDArray[np.float32]
    centre_xyz: NDArray[np.float64]

    @classmethod
    def from_sums(cls, sums: VoxelSums, centre_xyz: NDArray[np.floating]) -> CompactSums:
        """Round sums to single precision.

        Args:
            sums: In the columns of a `FrameContribution`.
            centre_xyz: (3,) [m] a position near the points.
        """
        means, weights = sums.totals.copy(), sums.totals[:, WEIGHT, None]
        means[:, POINT] = means[:, POINT] / weights - centre_xyz
        means[:, NORMAL] /= weights
        return cls(sums.keys, means.astype(np.float32), np.asarray(centre_xyz, np.float64))

    def expanded(self) -> VoxelSums:
        """The sums in double precision."""
        totals = self.means.astype(np.float64)
        weights = totals[:, WEIGHT, None]
        totals[:, POINT] = weights * (totals[:, POINT] + self.centre_xyz)
        totals[:, NORMAL] *= weights
        return VoxelSums(self.keys, totals)


@dataclass(frozen=True, eq=False)
class SubmapCollection:
    """Submaps by the number of their keyframe; `with_contribution` returns a new collection.

    Attributes:
        submaps: Number of the keyframe to its submap.
        latest: Number of the keyframe of the last contribution; only its submap has pending sums.
    """

    submaps: Mapping[int, Submap] = field(default_factory=lambda: MappingProxyType({}))
    latest: int | None = None

    def with_contribution(
        self, keyframe: int, T_map_keyframe: RigidTransform, contribution: FrameContribution
    ) -> SubmapCollection:
        """The collection with the contribution of one more frame.

        Args:
            keyframe: Number of the frame's reference keyframe.
            T_map_keyframe: Current pose of that keyframe.
            contribution: The contribution, map frame.

        Returns:
            A new collection; this one if the keyframe's submap has `MAX_SUBMAP_FRAMES` frames.
        """
        old = self.submaps.get(keyframe)
        if old is None:
            old = Submap.empty(T_map_keyframe.inv(), contribution.surface.origin_xyz)
        if len(old.views_xyz) >= MAX_SUBMAP_FRAMES:
            return self
        # Map and submap frame differ after a correction of the keyframe.
        T_map_submap = composed(T_map_keyframe, old.T_keyframe_submap)
        deviation = np.abs(T_map_submap.as_matrix() - np.eye(4)).max()
        uncorrected = deviation < UNCORRECTED_TOLERANCE
        local = contribution if uncorrected else contribution.transformed(T_map_submap.inv())
        submaps = {**self.submaps, keyframe: old.with_contribution(local)}
        if self.latest is not None and self.latest != keyframe:
            submaps[self.latest] = submaps[self.latest].compacted()
        if len(submaps) > MAX_SUBMAPS:
            others = [number for number in submaps if number != keyframe]
            del submaps[min(others, key=lambda number: len(submaps[number].views_xyz))]
        return SubmapCollection(MappingProxyType(submaps), keyframe)


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
