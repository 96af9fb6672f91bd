"""A scan with surface normals and their uncertainty, also packed for long-term storage."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.registration import _native
from circumspect.registration.scan import Scan

NORMAL_NEIGHBOURS = 10
"""Number of nearest points, the point itself included, that a normal is fitted to."""
MAX_FLOOR_HEIGHT_M = 0.05
"""Points within this height of z = 0 [m] may be floor, which looks the same everywhere."""
MIN_FLOOR_NORMAL_Z = 0.7
"""These points are floor if the z component of their normal is larger than this."""
MAX_NORMAL_VARIANCE_RAD2 = 0.25
"""Upper bound of the variance of a normal [rad²]. At this variance the normal is unknown."""


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


@dataclass(frozen=True, eq=False)
class ScanSurface:
    """A scan with normals.

    Attributes:
        scan: The scan.
        normals_xyz: (n, 3) unit vectors towards the camera, optical frame. Zero for a scan with
            too few points.
        normal_variances: (n,) [rad²] variance of the normal's tilt about each tangent direction.
        roughness: (n,) [m²] variance of the neighbours about their plane.
    """

    scan: Scan
    normals_xyz: NDArray[np.float64]
    normal_variances: NDArray[np.float64]
    roughness: NDArray[np.float64]

    @classmethod
    def from_scan(cls, scan: Scan, neighbours: int = NORMAL_NEIGHBOURS) -> ScanSurface:
        """Compute normals by principal component analysis of each point's neighbours.

        Let the plane z = a x + b y be fitted to k points. If the points have variance s² across
        the plane and λ along a slope, the slope has variance s² / (k λ). s² is estimated from the
        points, which lose three degrees of freedom to the plane. It is large near rims and edges,
        where the selection of neighbours is random as well.

        Args:
            scan: The scan.
            neighbours: Number of points that each normal is fitted to.
        """
        from scipy.spatial import KDTree

        points = scan.points_xyz
        if len(points) < neighbours:
            zeros = np.zeros(len(points))
            return cls(scan, np.zeros((len(points), 3)), zeros + MAX_NORMAL_VARIANCE_RAD2, zeros)
        # SciPy releases the interpreter lock for the next frame; small_gicp does not.
        _, nearest = KDTree(points).query(points, neighbours)
        normals, values = _native.plane_fits(points, np.asarray(nearest, np.int64))
        away = np.einsum("ij,ij->i", normals, points) > 0
        across = np.clip(values[:, 0], 0, None) * neighbours / (neighbours - 3)
        along = 0.5 * (1 / np.maximum(values[:, 1:], 1e-12)).sum(axis=1)
        variances = across / neighbours * along + scan.tilts
        variances = np.minimum(variances, MAX_NORMAL_VARIANCE_RAD2)
        return cls(scan, np.where(away[:, None], -normals, normals), variances, across)

    def with_vertical_floor_normals(self, T_map_camera: RigidTransform) -> ScanSurface:
        """The same surface with exactly vertical normals on the floor.

        Quantised depth turns a distant floor into steps, which move with the camera. Their tilted
        normals would hold the camera in place. A level floor constrains neither position nor
        heading.

        Args:
            T_map_camera: Pose of the camera. The robot stands on the floor at z = 0.
        """
        matrix = T_map_camera.as_matrix()
        up = matrix[2, :3]
        heights = self.scan.points_xyz @ up + matrix[2, 3]
        upward = self.normals_xyz @ up > MIN_FLOOR_NORMAL_Z
        floor = (np.abs(heights) < MAX_FLOOR_HEIGHT_M) & upward
        return replace(
            self,
            normals_xyz=np.where(floor[:, None], up, self.normals_xyz),
            normal_variances=np.where(floor, 0.0, self.normal_variances),
        )
