"""What frames showed of the object, kept so that the model can be built anew: `Rebuild`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.geometry.voxel_sums import VoxelSums
from circumspect.mapping import surface_area
from circumspect.mapping.compact_sums import CompactSums
from circumspect.mapping.frame_share import COLUMNS, FrameShare
from circumspect.mapping.sight_rays import SightRays

MOST = 300
"""So many patches are kept; the one that fewest frames showed gives way."""
ENOUGH = 40
"""A patch that so many frames showed takes no more in: their noise would add voxels for ever."""
WAITING = 8
"""So many frames of the latest patch wait for being added to its sums at once."""
FINE = 0.01
"""Side of the voxels [m] where nothing is known yet."""
STILL = 1e-9
"""Frames that differ by less [m] are one."""


@dataclass(frozen=True, eq=False)
class ViewPatch:
    """What the frames near one keyframe show of the object.

    Attributes:
        T_anchor_patch: The patch's own frame in the keyframe's: the map as it was when the patch
            began, so that a frame's share need not be computed twice until something is corrected.
        compact: Per voxel the sums of the model, those without that wait.
        areas: Per patch of surface, see `surface_area`.
        rays: That saw the object or passed it.
        views_xyz: (f, 3) [m] where the frames were taken from.
        waiting: Sums of the latest frames.
    """

    T_anchor_patch: RigidTransform
    compact: CompactSums
    areas: VoxelSums = field(default_factory=lambda: VoxelSums.empty(surface_area.COLUMNS))
    rays: SightRays = field(default_factory=SightRays.empty)
    views_xyz: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    waiting: tuple[VoxelSums, ...] = ()

    @classmethod
    def empty(cls, T_anchor_patch: RigidTransform, centre_xyz: NDArray[np.floating]) -> ViewPatch:
        """Before the first frame, which is taken from about `centre_xyz`."""
        return cls(T_anchor_patch, CompactSums.of(VoxelSums.empty(COLUMNS), centre_xyz))

    def __len__(self) -> int:
        """About how many voxels it has; those of frames that wait are counted by themselves."""
        return len(self.compact.keys) + sum(map(len, self.waiting))

    @property
    def sums(self) -> VoxelSums:
        """Per voxel the sums of all frames."""
        expanded = self.compact.expanded()
        return expanded.plus(*self.waiting) if self.waiting else expanded

    def with_share(self, local: FrameShare) -> ViewPatch:
        """The patch with what one more frame adds, in the patch's own frame."""
        origin_xyz = local.surface.origin_xyz
        patch = replace(
            self,
            areas=self.areas.plus(local.areas),
            rays=self.rays.with_frame(origin_xyz, local.ends_xyz, local.on_object),
            views_xyz=np.vstack([self.views_xyz, origin_xyz]),
            waiting=(*self.waiting, local.sums),
        )
        return patch.settled() if len(patch.waiting) >= WAITING else patch

    def settled(self) -> ViewPatch:
        """The same in as little memory as it takes: nothing waits."""
        if not self.waiting:
            return self
        compact = CompactSums.of(self.sums, self.compact.centre_xyz)
        return replace(self, compact=compact, waiting=())


@dataclass(frozen=True, eq=False)
class ObjectViews:
    """Patches by the number of their keyframe; `with_share` returns a new one.

    Attributes:
        patches: Keyframe to patch.
        latest: The keyframe whose patch took in a frame last; only there frames wait.
    """

    patches: Mapping[int, ViewPatch] = field(default_factory=lambda: MappingProxyType({}))
    latest: int | None = None

    def with_share(
        self, anchor: int, T_map_anchor: RigidTransform, share: FrameShare
    ) -> ObjectViews:
        """The views with what one more frame adds; nothing where they have enough from there.

        Args:
            anchor: Number of the keyframe that the frame hangs on.
            T_map_anchor: Where that is believed to be.
            share: What the frame adds, map frame.
        """
        old = self.patches.get(anchor)
        if old is None:
            old = ViewPatch.empty(T_map_anchor.inv(), share.surface.origin_xyz)
        if len(old.views_xyz) >= ENOUGH:
            return self
        # Where the keyframe was corrected since, the map is not the patch's frame any more.
        T_map_patch = composed(T_map_anchor, old.T_anchor_patch)
        still = np.abs(T_map_patch.as_matrix() - np.eye(4)).max() < STILL
        local = share if still else share.moved(T_map_patch.inv())
        patches = {**self.patches, anchor: old.with_share(local)}
        if self.latest is not None and self.latest != anchor:
            patches[self.latest] = patches[self.latest].settled()
        if len(patches) > MOST:
            others = [number for number in patches if number != anchor]
            del patches[min(others, key=lambda number: len(patches[number].views_xyz))]
        return ObjectViews(MappingProxyType(patches), anchor)
