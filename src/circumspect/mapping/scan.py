"""What one frame shows of the whole scene, thinned for registration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from circumspect.sensing import DepthBlocks, DepthNoise, RgbdFrame


@dataclass(frozen=True)
class ScanSettings:
    """How a frame is thinned.

    Attributes:
        block: Depths are averaged over square blocks of this side [px].
        voxel: Then averaged over voxels of this side [m].
        nearest, farthest: Only depths within this range [m] are used. A real structured-light
            camera that was not calibrated bends space from about 2.5 m on.
        enough: With fewer points than this within range, the sensor's own range counts, …
        flat: … and where they lie in one plane, nearer than this standard deviation [m]: bare
            floor holds neither place nor heading.
        noise: The camera's noise.
    """

    block: int = 4
    voxel: float = 0.03
    nearest: float = 0.3
    farthest: float = 2.5
    enough: int = 1200
    flat: float = 0.05
    noise: DepthNoise = field(default_factory=DepthNoise)


@dataclass(frozen=True, eq=False)
class Scan:
    """Points of a frame with their uncertainty, optical frame.

    Attributes:
        points_xyz: (n, 3) float64 [m].
        sigmas: (n,) [m] standard deviation along the ray.
    """

    points_xyz: NDArray[np.float64]
    sigmas: NDArray[np.float64]

    @classmethod
    def of(cls, frame: RgbdFrame, settings: ScanSettings | None = None) -> Scan:
        """Thin a frame; the scan is empty where no depth is within range."""
        s = settings or ScanSettings()
        blocks = DepthBlocks.of(frame.depth, frame.camera, s.block)
        rows, columns = np.nonzero(2 * blocks.counts >= s.block**2)
        points = blocks.points_xyz(rows, columns).astype(np.float64)
        near = (points[:, 2] > s.nearest) & (points[:, 2] < s.farthest)
        thin = _thinned(points[near], s.voxel)
        if len(thin) < s.enough or _thickness(thin) < s.flat:
            near = (points[:, 2] > s.nearest) & (points[:, 2] <= s.noise.farthest)
            thin = _thinned(points[near], s.voxel)
        return cls(thin, s.noise.axial_sigma(thin[:, 2]).astype(np.float64))

    def __len__(self) -> int:
        return len(self.points_xyz)

    def thinned(self, step: int) -> Scan:
        """Every `step`-th point."""
        return Scan(
            np.ascontiguousarray(self.points_xyz[::step]), np.ascontiguousarray(self.sigmas[::step])
        )


def _thinned(points_xyz: NDArray[np.float64], voxel: float) -> NDArray[np.float64]:
    import small_gicp

    if len(points_xyz) == 0:
        return points_xyz
    points = small_gicp.voxelgrid_sampling(points_xyz, voxel).points()
    return np.ascontiguousarray(np.asarray(points)[:, :3])


def _thickness(points_xyz: NDArray[np.float64]) -> float:
    """Standard deviation [m] across the plane that the points lie in best."""
    return float(np.sqrt(max(np.linalg.eigvalsh(np.cov(points_xyz.T))[0], 0.0)))
