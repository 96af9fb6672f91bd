"""The object model: fused surface and sight rays."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud, write_ply
from circumspect.geometry.voxel_sums import VoxelSums, group_sizes, voxel_keys
from circumspect.grid import Grid, OccupancyGrid
from circumspect.reconstruction import _native, surface_area
from circumspect.reconstruction.frame_contribution import (
    COLUMNS,
    FRAMES,
    FrameContribution,
    coarsened,
)
from circumspect.reconstruction.frame_surface import FrameSurface
from circumspect.reconstruction.occupancy import occupancies, occupancy
from circumspect.reconstruction.sight_rays import SightRays
from circumspect.sensing import RgbdFrame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_FINE_VOXELS = 40_000
"""The preview of a model with more voxels than this has voxels of twice the side."""
MAX_PENDING_ROWS = 60_000
"""Maximum number of rows of sums that a large model collects before it adds them."""


@dataclass(frozen=True)
class ModelSettings:
    """Settings of fusion.

    Attributes:
        voxel: Side of the voxels over which points are averaged [m]. None means 1/150 of the
            median distance of the object in the first frame, rounded to mm and clipped to 6 to
            12 mm: about 4 x 4 pixels.
        min_frames: Frames that must observe a voxel, once `min_frames_after` frames are fused.
        min_frames_after: See `min_frames`.
        min_density: A voxel is an outlier if its block of 3 x 3 x 3 voxels holds fewer than this
            many occupied ones.
        max_width: Objects wider than this are rejected as parts of the room [m].
    """

    voxel: float | None = None
    min_frames: int = 2
    min_frames_after: int = 8
    min_density: int = 3
    max_width: float = 4.0


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """The fused surface of one object, map frame. Models are immutable; `fused` returns a new one.

    Attributes:
        settings: Settings of fusion.
        voxel: Side of the voxels [m]; None before the first frame.
        base: Sums per voxel over frames, without the pending ones.
        areas: Area and frame count per surface patch; see `surface_area`.
        rays: Rays that hit the object or pass close to it.
        views_xyz: (f, 3) [m] camera positions.
        coarse: Sums per voxel of twice the side; None for at most `MAX_FINE_VOXELS` voxels.
        pending: Sums of the latest frames of a model with more voxels.
    """

    settings: ModelSettings = field(default_factory=ModelSettings)
    voxel: float | None = None
    base: VoxelSums = field(default_factory=lambda: VoxelSums.empty(COLUMNS))
    areas: VoxelSums = field(default_factory=lambda: VoxelSums.empty(surface_area.COLUMNS))
    rays: SightRays = field(default_factory=SightRays.empty)
    views_xyz: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    coarse: VoxelSums | None = None
    pending: tuple[VoxelSums, ...] = ()

    def __repr__(self) -> str:
        return f"ObjectModel({len(self.sums)} points, {self.frames} frames)"

    @property
    def frames(self) -> int:
        """Number of fused frames."""
        return len(self.views_xyz)

    def __post_init__(self) -> None:
        if self.voxel is None:
            object.__setattr__(self, "voxel", self.settings.voxel)

    @property
    def preview(self) -> ObjectModel:
        """A preview model of bounded cost, for results after every frame.

        It has voxels of twice the side if this model has more than `MAX_FINE_VOXELS`. A small model
        is its own preview. Results from the preview model are provisional.
        """
        return self if self.coarse is None else self._preview

    @cached_property
    def _preview(self) -> ObjectModel:
        # Never `self`: a model that refers to itself is freed by the cycle collector only, and
        # hundreds of megabytes of past models would accumulate until then.
        assert self.coarse is not None
        return replace(
            self, voxel=2 * (self.voxel or 0.0), base=self.coarse, coarse=None, pending=()
        )

    @cached_property
    def sums(self) -> VoxelSums:
        """Sums per voxel over all frames."""
        return self.base.plus(*self.pending) if self.pending else self.base

    @cached_property
    def points_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m] mean point of every voxel, outliers included; may be empty."""
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
            object_mask: (height, width) True for pixels that show the object.
            T_map_camera: Pose of the camera.

        Returns:
            A new model; this one if the mask contains no valid depth.

        Raises:
            ValueError: The mask and the frame differ in size.
        """
        return self.with_surface(FrameSurface.from_frame(frame, object_mask, T_map_camera))

    def with_surface(self, surface: FrameSurface) -> ObjectModel:
        """The model with the surface of one more frame; this one if the surface is empty."""
        contribution = self.contribution(surface)
        return self if contribution is None else self.with_contribution(contribution)

    def contribution(self, surface: FrameSurface) -> FrameContribution | None:
        """The contribution of a frame to this model; None if the surface is empty."""
        if len(surface.points_xyz) == 0:
            return None
        known_xyz = self.preview.points_xyz
        return FrameContribution.from_surface(
            surface, self.voxel or _default_voxel(surface), known_xyz
        )

    def with_contribution(self, contribution: FrameContribution) -> ObjectModel:
        """The model with the contribution of one more frame."""
        origin_xyz = contribution.surface.origin_xyz
        ends_xyz, on_object = contribution.ends_xyz, contribution.on_object
        return replace(
            self,
            voxel=contribution.voxel,
            areas=self.areas.plus(contribution.areas),
            rays=self.rays.with_frame(origin_xyz, ends_xyz, on_object),
            views_xyz=np.vstack([self.views_xyz, origin_xyz]),
        ).with_sums(contribution.sums)

    def with_sums(self, more: VoxelSums) -> ObjectModel:
        """The model with further sums per voxel; coarse sums are updated as well."""
        if self.coarse is None:
            sums = self.base.plus(more)
            coarse = coarsened(sums) if len(sums) > MAX_FINE_VOXELS else None
            return replace(self, base=sums, coarse=coarse)
        coarse, pending = self.coarse.plus(coarsened(more)), (*self.pending, more)
        if sum(map(len, pending)) < MAX_PENDING_ROWS:
            return replace(self, coarse=coarse, pending=pending)
        return replace(self, base=self.base.plus(*pending), coarse=coarse, pending=())

    def cloud(self) -> PointCloud:
        """The surface without outliers, as points with normals and areas.

        Raises:
            GeometryError: No frame is fused yet.
        """
        return self._cloud

    def frames_seen(self) -> NDArray[np.int64]:
        """(n,) number of frames that observed each point of `cloud`.

        Raises:
            GeometryError: No frame is fused yet.
        """
        return self.sums.totals[self._inliers, FRAMES].astype(np.int64)

    @cached_property
    def _inliers(self) -> NDArray[np.intp]:
        """Indices of the voxels that are not outliers."""
        if len(self.sums) == 0:
            raise GeometryError("the model is empty: no frame has shown the object yet")
        return np.flatnonzero(self._is_inlier(self.points_xyz))

    @cached_property
    def _cloud(self) -> PointCloud:
        inliers = self._inliers
        points, normals = (values.take(inliers, axis=0) for values in self._means)
        areas = surface_area.point_areas(self.areas, points, normals)
        for values in (points, normals):
            values.flags.writeable = False  # Else the cloud copies them.
        return PointCloud(points, areas=areas, normals_xyz=normals)

    def occupancy(self, grid: Grid) -> OccupancyGrid:
        """Unknown, free and occupied cells of a grid around the object.

        Raises:
            GeometryError: No frame is fused yet.
        """
        return occupancy(grid, self.cloud().points_xyz, self.rays)

    def occupancies(self, grids: Sequence[Grid]) -> list[OccupancyGrid]:
        """`occupancy` for several cylindrical grids around one axis, in a single pass.

        Raises:
            GeometryError: No frame is fused yet.
            InputError: The grids are not cylindrical, or do not share their axis.
        """
        return occupancies(grids, self.cloud().points_xyz, self.rays)

    def plot(
        self, axes: Axes | None = None, azimuth_deg: float = -60.0, elevation_deg: float = 25.0
    ) -> Axes:
        """Draw the surface in parallel projection; see `PointCloud.plot`.

        Args:
            axes: Axes to draw into; None for a new figure.
            azimuth_deg: Azimuth of the viewer as seen from the object [degrees].
            elevation_deg: Elevation of the viewer above the horizon [degrees].

        Raises:
            GeometryError: No frame is fused yet.
            MissingExtraError: matplotlib is not installed.
        """
        return self.cloud().plot(axes, azimuth_deg, elevation_deg)

    def to_dict(self) -> dict[str, Any]:
        """Number of points and frames, voxel and size of the object [m], in JSON types.

        Raises:
            GeometryError: No frame is fused yet.
        """
        points = self.cloud().points_xyz
        return {
            "points": len(points),
            "frames": self.frames,
            "voxel_m": self.voxel,
            "size_m": np.ptp(points, axis=0).tolist(),
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the cloud as PLY, with `frames_seen` as the vertex property "frames".

        Raises:
            GeometryError: No frame is fused yet.
            OutputError: The file cannot be written.
        """
        write_ply(path, self.cloud(), {"frames": self.frames_seen()})

    def _is_inlier(self, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
        blocks = voxel_keys(points_xyz, 3 * (self.voxel or 0.0))
        inlier = group_sizes(blocks) >= self.settings.min_density
        if self.frames >= self.settings.min_frames_after:
            inlier &= self.sums.totals[:, FRAMES] >= self.settings.min_frames
        # A model of only outliers, such as a few points, keeps all of them.
        return inlier if inlier.any() else np.ones(len(inlier), bool)


def _default_voxel(surface: FrameSurface) -> float:
    distances = np.linalg.norm(surface.points_xyz - surface.origin_xyz, axis=1)
    return round(float(np.clip(np.median(distances) / 150, 0.006, 0.012)), 3)
