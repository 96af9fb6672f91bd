"""What one frame adds to what is known of the object, computed once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.voxel_sums import VoxelSums, coarser_keys, group_maxima, voxel_keys
from circumspect.mapping import _native, surface_area
from circumspect.mapping.frame_surface import FrameSurface

# Columns of the sums: weight, weighted point (3), weighted normal (3), frames.
WEIGHT, POINT, NORMAL, FRAMES, COLUMNS = 0, slice(1, 4), slice(4, 7), 7, 8


@dataclass(frozen=True, eq=False)
class FrameShare:
    """Sums and rays of one frame.

    Attributes:
        surface: What the frame shows.
        voxel: Side of the voxels [m].
        sums: Per voxel, see the columns above.
        areas: Per patch of surface, see `surface_area`.
        ends_xyz: (m, 3) [m] where rays end that saw the object or passed it.
        on_object: (m,) bool.
    """

    surface: FrameSurface
    voxel: float
    sums: VoxelSums
    areas: VoxelSums
    ends_xyz: NDArray[np.float64]
    on_object: NDArray[np.bool_]

    @classmethod
    def of(cls, surface: FrameSurface, voxel: float, known_xyz: NDArray[np.float64]) -> FrameShare:
        """Sum a frame up.

        Args:
            surface: What the frame shows.
            voxel: Side of the voxels [m].
            known_xyz: (k, 3) [m] points of the object from earlier frames.
        """
        ends, on_object = surface.rays_beside(known_xyz)
        areas = surface_area.frame_areas(surface)
        return cls(surface, voxel, _sums(surface, voxel), areas, ends, on_object)

    def moved(self, T_target_map: RigidTransform) -> FrameShare:
        """The same in another frame, with that frame's voxels."""
        local = self.surface.moved(T_target_map)
        return FrameShare(
            local,
            self.voxel,
            _sums(local, self.voxel),
            surface_area.frame_areas(local),
            T_target_map.apply(self.ends_xyz),
            self.on_object,
        )


def coarser(sums: VoxelSums) -> VoxelSums:
    """The same over voxels of twice the side, each seen in as many frames as any part of it.

    Added up frame by frame, they were seen in as many as any or several of their parts were.
    """
    keys = coarser_keys(sums.keys)
    both = VoxelSums.from_rows(keys, sums.totals)
    both.totals[:, FRAMES] = group_maxima(keys, sums.totals[:, FRAMES])
    return both


def _sums(surface: FrameSurface, voxel: float) -> VoxelSums:
    keys = voxel_keys(surface.points_xyz, voxel)
    return VoxelSums(
        *_native.surface_sums(surface.points_xyz, surface.normals_xyz, surface.weights, keys)
    )
