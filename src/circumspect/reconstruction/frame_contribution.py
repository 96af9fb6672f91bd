"""The contribution of one frame to the object model, computed once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.voxel_sums import VoxelSums, coarser_keys, group_maxima, voxel_keys
from circumspect.reconstruction import _native, surface_area
from circumspect.reconstruction.frame_surface import FrameSurface

# Columns of the sums: weight, weighted point (3), weighted normal (3), frames.
WEIGHT, POINT, NORMAL, FRAMES, COLUMNS = 0, slice(1, 4), slice(4, 7), 7, 8


@dataclass(frozen=True, eq=False)
class FrameContribution:
    """Voxel sums, surface areas and rays of one frame.

    Attributes:
        surface: The object's surface in the frame.
        voxel: Side of the voxels [m].
        sums: Sums per voxel, in the columns above.
        areas: Area and frame count per surface patch; see `surface_area`.
        ends_xyz: (m, 3) [m] ends of the rays that hit the object or pass close to it.
        on_object: (m,) bool: the ray ends on the object.
    """

    surface: FrameSurface
    voxel: float
    sums: VoxelSums
    areas: VoxelSums
    ends_xyz: NDArray[np.float64]
    on_object: NDArray[np.bool_]

    @classmethod
    def from_surface(
        cls, surface: FrameSurface, voxel: float, known_xyz: NDArray[np.float64]
    ) -> FrameContribution:
        """Compute the contribution of a frame.

        Args:
            surface: The object's surface in the frame.
            voxel: Side of the voxels [m].
            known_xyz: (k, 3) [m] points of the object from earlier frames.
        """
        ends, on_object = surface.rays_near_object(known_xyz)
        areas = surface_area.frame_areas(surface)
        return cls(surface, voxel, _sums(surface, voxel), areas, ends, on_object)

    def transformed(self, T_target_map: RigidTransform) -> FrameContribution:
        """The contribution in the target frame, summed over the voxels of that frame."""
        local = self.surface.transformed(T_target_map)
        return FrameContribution(
            local,
            self.voxel,
            _sums(local, self.voxel),
            surface_area.frame_areas(local),
            T_target_map.apply(self.ends_xyz),
            self.on_object,
        )


def coarsened(sums: VoxelSums) -> VoxelSums:
    """Sums over voxels of twice the side.

    The frame count of a coarse voxel is the largest count of its parts, a lower bound of the number
    of frames that observed any of them.
    """
    keys = coarser_keys(sums.keys)
    coarse = VoxelSums.from_rows(keys, sums.totals)
    coarse.totals[:, FRAMES] = group_maxima(keys, sums.totals[:, FRAMES])
    return coarse


def _sums(surface: FrameSurface, voxel: float) -> VoxelSums:
    keys = voxel_keys(surface.points_xyz, voxel)
    return VoxelSums(
        *_native.surface_sums(surface.points_xyz, surface.normals_xyz, surface.weights, keys)
    )
