"""Points of one frame with their uncertainty, downsampled for registration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from circumspect.sensing import DepthBlocks, DepthNoise, RgbdFrame

PATCHES_PER_ROW = 1 << 20
WHITE_CORRELATION = 4.0
"""Number of points whose white noise carries the information of one independent measurement.
Averaging over blocks, voxels and normals correlates the errors of neighbours (measured,
docs/derivations.md)."""


@dataclass(frozen=True)
class DownsamplingSettings:
    """Settings of the downsampling of a frame to a scan.

    Attributes:
        block: Depths are averaged over square blocks of this side [px].
        voxel: Points are then averaged over voxels of this side [m].
        min_depth: Smaller depths are discarded [m].
        max_depth: Larger depths are discarded [m].
        noise: Noise of the camera.
    """

    block: int = 4
    voxel: float = 0.03
    min_depth: float = 0.3
    max_depth: float = 2.5
    noise: DepthNoise = field(default_factory=DepthNoise)


@dataclass(frozen=True, eq=False)
class Scan:
    """Points of a frame with their uncertainty, optical frame.

    Attributes:
        points_xyz: (n, 3) float64 [m].
        sigmas: (n,) [m] standard deviation of the depth, from white and systematic errors.
        correlations: (n,) number of points that carry the information of one.
        tilts: (n,) [rad²] variance of the surface's slope from systematic errors.
    """

    points_xyz: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    correlations: NDArray[np.float64]
    tilts: NDArray[np.float64]

    @classmethod
    def from_frame(cls, frame: RgbdFrame, settings: DownsamplingSettings | None = None) -> Scan:
        """Downsample a frame. The scan is empty if no depth is in range.

        Args:
            frame: The frame.
            settings: Settings of the downsampling.
        """
        s = settings or DownsamplingSettings()
        blocks = DepthBlocks.of(frame.depth, frame.camera, s.block)
        rows, columns = np.nonzero(2 * blocks.counts >= s.block**2)
        points = blocks.points_xyz(rows, columns).astype(np.float64)
        in_range = (points[:, 2] > s.min_depth) & (points[:, 2] < s.max_depth)
        means = _voxel_means(points[in_range], s.voxel)
        return cls(means, *_errors(means, s.noise))

    @classmethod
    def with_white_noise(cls, points_xyz: NDArray[np.float64], sigmas: NDArray[np.float64]) -> Scan:
        """A scan without systematic errors; see the attributes."""
        ones = np.ones(len(points_xyz))
        return cls(points_xyz, sigmas, WHITE_CORRELATION * ones, 0 * ones)

    def __len__(self) -> int:
        return len(self.points_xyz)

    def subsampled(self, step: int) -> Scan:
        """Every `step`-th point."""
        arrays = self.points_xyz, self.sigmas, self.correlations, self.tilts
        return Scan(*(np.ascontiguousarray(values[::step]) for values in arrays))


def _errors(
    points_xyz: NDArray[np.float64], noise: DepthNoise
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Standard deviations [m], correlations and tilts [rad²] of points.

    The depth error has a white part with variance σ² and a systematic part with variance ς². Of the
    white part, c = `WHITE_CORRELATION` points carry the information of one. All n points of a patch
    share the systematic part: the patch is one measurement with variance (c σ² + n ς²) / n.
    """
    z = points_xyz[:, 2]
    white = noise.axial_sigma(z).astype(np.float64) ** 2
    systematic = noise.systematic_sigma(z) ** 2
    patch = noise.systematic_patch
    columns, rows = np.floor(points_xyz[:, :2].T / z / patch).astype(np.int64)
    _, inverse, counts = np.unique(
        rows * PATCHES_PER_ROW + columns, return_inverse=True, return_counts=True
    )
    total = white + systematic
    correlations = (WHITE_CORRELATION * white + counts[inverse] * systematic) / total
    extent = patch * z
    return np.sqrt(total), correlations, 4 / 3 * systematic / extent**2


def _voxel_means(points_xyz: NDArray[np.float64], voxel: float) -> NDArray[np.float64]:
    import small_gicp

    if len(points_xyz) == 0:
        return points_xyz
    points = small_gicp.voxelgrid_sampling(points_xyz, voxel).points()
    return np.ascontiguousarray(np.asarray(points)[:, :3])
