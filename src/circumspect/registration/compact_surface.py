"""A scan surface in single precision, for long-term storage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.registration.scan import Scan
from circumspect.registration.scan_surface import ScanSurface


@dataclass(frozen=True, eq=False)
class CompactSurface:
    """A `ScanSurface` in single precision, which resolves 0.2 µm at a distance of 3 m.

    Attributes:
        points_xyz: (n, 3) float32 [m] optical frame.
        sigmas: (n,) float32 [m].
        correlations: (n,) float32.
        tilts: (n,) float32 [rad²].
        normals_xyz: (n, 3) float32.
        normal_variances: (n,) float32 [rad²].
        roughness: (n,) float32 [m²].
    """

    points_xyz: NDArray[np.float32]
    sigmas: NDArray[np.float32]
    correlations: NDArray[np.float32]
    tilts: NDArray[np.float32]
    normals_xyz: NDArray[np.float32]
    normal_variances: NDArray[np.float32]
    roughness: NDArray[np.float32]

    @classmethod
    def from_surface(cls, surface: ScanSurface) -> CompactSurface:
        """Round a surface to single precision."""
        scan = surface.scan
        arrays = (
            scan.points_xyz,
            scan.sigmas,
            scan.correlations,
            scan.tilts,
            surface.normals_xyz,
            surface.normal_variances,
            surface.roughness,
        )
        return cls(*(values.astype(np.float32) for values in arrays))

    def expanded(self) -> ScanSurface:
        """The surface in double precision."""
        arrays = (self.points_xyz, self.sigmas, self.correlations, self.tilts)
        scan = Scan(*(values.astype(np.float64) for values in arrays))
        others = (self.normals_xyz, self.normal_variances, self.roughness)
        return ScanSurface(scan, *(values.astype(np.float64) for values in others))
