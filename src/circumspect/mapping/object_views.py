"""What frames showed of the object, kept so that the model can be built anew: `Rebuild`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.mapping import surface_area
from circumspect.mapping.compact_sums import CompactSums
from circumspect.mapping.frame_share import COLUMNS, FrameShare
from circumspect.mapping.sight_rays import SightRays
from circumspect.mapping.voxel_sums import VoxelSums

MOST = 300
"""So many patches are kept; the one that fewest frames showed gives way."""
ENOUGH = 40
"""A patch that so many frames showed takes no more in: their noise would add voxels for ever."""
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
        sums: Per voxel those of the model.
        areas: Per patch of surface, see `surface_area`.
        rays: That saw the object or passed it.
        views_xyz: (f, 3) [m] where the frames were taken from.
    """

    T_anchor_patch: RigidTransform
    sums: CompactSums
    areas: VoxelSums = field(default_factory=lambda: VoxelSums.empty(surface_area.COLUMNS))
    rays: SightRays = field(default_factory=SightRays.empty)
    views_xyz: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))

    @classmethod
    def empty(cls, T_anchor_patch: RigidTransform, centre_xyz: NDArray[np.floating]) -> ViewPatch:
        """Before the first frame, which is taken from about `centre_xyz`."""
        return cls(T_anchor_patch, CompactSums.of(VoxelSums.empty(COLUMNS), centre_xyz))


@dataclass(frozen=True, eq=False)
class ObjectViews:
    """Patches by the number of their keyframe; `with_share` returns a new one.

    Attributes:
        patches: Keyframe to patch.
    """

    patches: Mapping[int, ViewPatch] = field(default_factory=lambda: MappingProxyType({}))

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
        origin_xyz = local.surface.origin_xyz
        sums = old.sums.expanded().plus(local.sums)
        patch = ViewPatch(
            old.T_anchor_patch,
            CompactSums.of(sums, old.sums.centre_xyz),
            old.areas.plus(local.areas),
            old.rays.with_frame(origin_xyz, local.ends_xyz, local.on_object),
            np.vstack([old.views_xyz, origin_xyz]),
        )
        patches = {**self.patches, anchor: patch}
        if len(patches) > MOST:
            others = [number for number in patches if number != anchor]
            del patches[min(others, key=lambda number: len(patches[number].views_xyz))]
        return replace(self, patches=MappingProxyType(patches))
