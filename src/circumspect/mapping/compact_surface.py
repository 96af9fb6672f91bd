"""The surface that a scan shows in half the memory, to be kept for long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import ScanSurface


@dataclass(frozen=True, eq=False)
class CompactSurface:
    """A `ScanSurface` in single precision, which tells 0.2 µm of a point 3 m off.

    Attributes:
        points_xyz: (n, 3) float32 [m] optical frame.
        sigmas: (n,) float32 [m].
        normals_xyz: (n, 3) float32.
        slopes: (n,) float32 [rad²].
        unevenness: (n,) float32 [m²].
    """

    points_xyz: NDArray[np.float32]
    sigmas: NDArray[np.float32]
    normals_xyz: NDArray[np.float32]
    slopes: NDArray[np.float32]
    unevenness: NDArray[np.float32]

    @classmethod
    def of(cls, surface: ScanSurface) -> CompactSurface:
        """Round a surface."""
        scan = surface.scan
        kept = (
            scan.points_xyz, scan.sigmas, surface.normals_xyz, surface.slopes, surface.unevenness
        )  # fmt: skip
        return cls(*(values.astype(np.float32) for values in kept))

    def expanded(self) -> ScanSurface:
        """The surface in double precision."""
        scan = Scan(self.points_xyz.astype(np.float64), self.sigmas.astype(np.float64))
        others = (self.normals_xyz, self.slopes, self.unevenness)
        return ScanSurface(scan, *(values.astype(np.float64) for values in others))
