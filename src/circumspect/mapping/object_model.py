"""What is known of the object: its surface, and the rays that saw it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud, write_ply
from circumspect.geometry.voxel_sums import VoxelSums, group_sizes, voxel_keys
from circumspect.grid import Grid, OccupancyGrid
from circumspect.mapping import _native, surface_area
from circumspect.mapping.frame_share import COLUMNS, FRAMES, FrameShare, coarser
from circumspect.mapping.frame_surface import FrameSurface
from circumspect.mapping.occupancy import occupancies, occupancy
from circumspect.mapping.sight_rays import SightRays
from circumspect.sensing import RgbdFrame

LARGE = 40_000
"""While frames come, a model of more voxels is looked at in voxels of twice the side …"""
MOST_RAYS = 30_000
"""… and at most so many of its rays are traced."""
WAITING = 60_000
"""So many rows of a large model's frames wait for being added to its sums at once."""


@dataclass(frozen=True)
class ModelSettings:
    """How frames are fused.

    Attributes:
        voxel: Side of the voxels over which points are averaged [m]; None means a 150th of the
            object's distance in the first frame, in whole mm from 6 to 12: about 4 x 4 pixels of
            what is near, and no coarser than what the model is wanted for.
        confirmed_by: Once `frames_until_strict` frames are fused, a voxel needs this many.
        frames_until_strict: See above.
        crowd: Voxels with fewer than this many in their block of 3 x 3 x 3 are specks.
        widest: What is wider than this is no object but the room [m].
    """

    voxel: float | None = None
    confirmed_by: int = 2
    frames_until_strict: int = 8
    crowd: int = 3
    widest: float = 4.0


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """The fused surface of one object in the map frame; `fused` returns a new one.

    Attributes:
        settings: How frames are fused.
        voxel: Side of the voxels [m]; None before the first frame.
        base: Per voxel sums over frames, those without that wait.
        areas: Per patch of surface, see `surface_area`.
        rays: The rays that saw the object or passed it.
        views_xyz: (f, 3) [m] where the frames were taken from.
        coarse: Per voxel of twice the side sums over frames; None while the model is not large.
        waiting: Sums of the latest frames of a large model.
    """

    settings: ModelSettings = field(default_factory=ModelSettings)
    voxel: float | None = None
    base: VoxelSums = field(default_factory=lambda: VoxelSums.empty(COLUMNS))
    areas: VoxelSums = field(default_factory=lambda: VoxelSums.empty(surface_area.COLUMNS))
    rays: SightRays = field(default_factory=SightRays.empty)
    views_xyz: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    coarse: VoxelSums | None = None
    waiting: tuple[VoxelSums, ...] = ()

    def __repr__(self) -> str:
        return f"ObjectModel({len(self.sums)} points, {self.frames} frames)"

    @property
    def frames(self) -> int:
        """How many frames are fused."""
        return len(self.views_xyz)

    def __post_init__(self) -> None:
        if self.voxel is None:
            object.__setattr__(self, "voxel", self.settings.voxel)

    @property
    def sketch(self) -> ObjectModel:
        """Itself; of a large model one of voxels of twice the side, of many rays one of fewer.

        What is reported after every frame must not take longer the larger the object is.
        """
        is_small = self.coarse is None and len(self.rays) <= MOST_RAYS
        return self if is_small else self._sketch

    @cached_property
    def _sketch(self) -> ObjectModel:
        # Never the model itself: one that holds itself waits for the cycle collector, and thereby
        # hundreds of megabytes of models that are past.
        rays = self.rays.at_most(MOST_RAYS)
        if self.coarse is None:
            return replace(self, rays=rays)
        return replace(
            self,
            voxel=2 * (self.voxel or 0.0),
            base=self.coarse,
            rays=rays,
            coarse=None,
            waiting=(),
        )

    @cached_property
    def sums(self) -> VoxelSums:
        """Per voxel sums over all frames."""
        return self.base.plus(*self.waiting) if self.waiting else self.base

    @cached_property
    def points_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m]: mean point of every voxel, specks included; may be empty."""
        return self._means[0]

    @cached_property
    def _means(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean point and mean unit normal of every voxel."""
        return _native.surface_means(self.sums.totals)

    def fused(
        self, frame: RgbdFrame, object_mask: NDArray[np.bool_], T_map_camera: RigidTransform
    ) -> ObjectModel:
        """The model with one more frame.

        Args:
            frame: The frame.
            object_mask: (height, width) the object's pixels.
            T_map_camera: Where it was taken from.

        Returns:
            A new model; this one where the mask shows no surface.

        Raises:
            ValueError: The mask is not as large as the frame.
        """
        return self.with_surface(FrameSurface.of(frame, object_mask, T_map_camera))

    def with_surface(self, surface: FrameSurface) -> ObjectModel:
        """The model with what one more frame shows; this one where that is nothing."""
        share = self.share(surface)
        return self if share is None else self.with_share(share)

    def share(self, surface: FrameSurface) -> FrameShare | None:
        """What a frame adds to this model; None where that is nothing."""
        if len(surface.points_xyz) == 0:
            return None
        known_xyz = self.sketch.points_xyz
        return FrameShare.of(surface, self.voxel or _fitting_voxel(surface), known_xyz)

    def with_share(self, share: FrameShare) -> ObjectModel:
        """The model with what one more frame adds."""
        origin_xyz = share.surface.origin_xyz
        return replace(
            self,
            voxel=share.voxel,
            areas=self.areas.plus(share.areas),
            rays=self.rays.with_frame(origin_xyz, share.ends_xyz, share.on_object),
            views_xyz=np.vstack([self.views_xyz, origin_xyz]),
        ).with_sums(share.sums)

    def with_sums(self, more: VoxelSums) -> ObjectModel:
        """The model with sums of further frames, those over coarse voxels included."""
        if self.coarse is None:
            sums = self.base.plus(more)
            coarse = coarser(sums) if len(sums) > LARGE else None
            return replace(self, base=sums, coarse=coarse)
        coarse, waiting = self.coarse.plus(coarser(more)), (*self.waiting, more)
        if sum(map(len, waiting)) < WAITING:
            return replace(self, coarse=coarse, waiting=waiting)
        return replace(self, base=self.base.plus(*waiting), coarse=coarse, waiting=())

    def cloud(self) -> PointCloud:
        """The surface without specks, each point with its normal and area.

        Raises:
            GeometryError: Nothing is fused yet.
        """
        return self._cloud

    def frames_seen(self) -> NDArray[np.int64]:
        """(n,) how many frames showed each point of `cloud`.

        Raises:
            GeometryError: Nothing is fused yet.
        """
        return self.sums.totals[self._kept, FRAMES].astype(np.int64)

    @cached_property
    def _kept(self) -> NDArray[np.intp]:
        """The voxels that are no specks."""
        if len(self.sums) == 0:
            raise GeometryError("the model is empty: no frame has shown the object yet")
        return np.flatnonzero(self._confirmed(self.points_xyz))

    @cached_property
    def _cloud(self) -> PointCloud:
        kept = self._kept
        points, normals = (values.take(kept, axis=0) for values in self._means)
        areas = surface_area.point_areas(self.areas, points, normals)
        for values in (points, normals):
            values.flags.writeable = False  # Else the cloud copies them.
        return PointCloud(points, areas=areas, normals_xyz=normals)

    def occupancy(self, grid: Grid) -> OccupancyGrid:
        """Unknown, free and occupied cells of a grid around the object.

        Raises:
            GeometryError: Nothing is fused yet.
        """
        return occupancy(grid, self.cloud().points_xyz, self.rays)

    def occupancies(self, grids: Sequence[Grid]) -> list[OccupancyGrid]:
        """The same of several cylindrical grids about one axis, in one pass.

        Raises:
            GeometryError: Nothing is fused yet.
            InputError: The grids are of another kind, or do not share their axis.
        """
        return occupancies(grids, self.cloud().points_xyz, self.rays)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the cloud as PLY, with the number of frames that showed each point ("frames").

        Raises:
            GeometryError: Nothing is fused yet.
            OutputError: The file can not be written.
        """
        write_ply(path, self.cloud(), {"frames": self.frames_seen()})

    def _confirmed(self, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
        blocks = voxel_keys(points_xyz, 3 * (self.voxel or 0.0))
        kept = group_sizes(blocks) >= self.settings.crowd
        if self.frames >= self.settings.frames_until_strict:
            kept &= self.sums.totals[:, FRAMES] >= self.settings.confirmed_by
        # Of an object of a few points everything is kept rather than nothing.
        return kept if kept.any() else np.ones(len(kept), bool)


def _fitting_voxel(surface: FrameSurface) -> float:
    away = np.linalg.norm(surface.points_xyz - surface.origin_xyz, axis=1)
    return round(float(np.clip(np.median(away) / 150, 0.006, 0.012)), 3)
