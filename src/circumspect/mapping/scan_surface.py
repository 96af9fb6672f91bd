"""The surface that a scan shows: normals, and how far they are to be trusted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.grid.grid_arguments import checked_threads
from circumspect.mapping import _native
from circumspect.mapping.scan import Scan

NEIGHBOURS = 10
"""Points over which a normal is taken."""
FLOOR = 0.05
"""What is within this height of z = 0 [m] may be floor, and floor looks the same everywhere."""
UPRIGHT = 0.7
"""What is near z = 0 with a normal that points up by more than this is floor."""
STEEPEST = 0.25
"""No slope has a larger variance [rad²]: the normal is unknown then."""


@dataclass(frozen=True, eq=False)
class ScanSurface:
    """A scan with normals.

    Attributes:
        scan: The scan.
        normals_xyz: (n, 3) unit vectors towards the camera, optical frame; zero where too few
            points are near.
        slopes: (n,) [rad²] variance of a normal about each direction within the surface.
        unevenness: (n,) [m²] variance of the points about the plane of their neighbours.
    """

    scan: Scan
    normals_xyz: NDArray[np.float64]
    slopes: NDArray[np.float64]
    unevenness: NDArray[np.float64]

    @classmethod
    def of(cls, scan: Scan, neighbours: int = NEIGHBOURS) -> ScanSurface:
        """Principal components of each point's surroundings.

        The plane z = a x + b y fitted to k points whose noise across it has variance s² has slopes
        with variance s² / (k λ), λ being the variance of the points along the slope; s² is
        told by the points themselves, which lose three degrees of freedom to the plane. Near rims
        and edges it is large: which points of a bend are drawn is chance, too.

        Args:
            scan: The scan.
            neighbours: Points over which each normal is taken.
        """
        from small_gicp import KdTree

        points = scan.points_xyz
        if len(points) < neighbours:
            nothing = np.zeros(len(points))
            return cls(scan, np.zeros((len(points), 3)), nothing + STEEPEST, nothing)
        cores = checked_threads(0)
        near, _ = KdTree(points).batch_knn_search(points, neighbours, num_threads=cores)
        normals, values = _native.plane_fits(points, np.asarray(near, np.int64), threads=cores)
        away = np.einsum("ij,ij->i", normals, points) > 0
        across = np.clip(values[:, 0], 0, None) * neighbours / (neighbours - 3)
        along = 0.5 * (1 / np.maximum(values[:, 1:], 1e-12)).sum(axis=1)
        slopes = np.minimum(across / neighbours * along, STEEPEST)
        return cls(scan, np.where(away[:, None], -normals, normals), slopes, across)

    def on_level_floor(self, T_map_camera: RigidTransform) -> ScanSurface:
        """The same, with the normals of the floor exactly vertical.

        Depth that is quantised makes steps of a floor that lies far off. They move with the
        camera, and their slanted normals would hold it to where it was; a level floor says nothing
        of place and heading.

        Args:
            T_map_camera: Where a robot that stands on the floor at z = 0 took it from.
        """
        matrix = T_map_camera.as_matrix()
        up = matrix[2, :3]
        heights = self.scan.points_xyz @ up + matrix[2, 3]
        floor = (np.abs(heights) < FLOOR) & (self.normals_xyz @ up > UPRIGHT)
        normals = np.where(floor[:, None], up, self.normals_xyz)
        return replace(self, normals_xyz=normals, slopes=np.where(floor, 0.0, self.slopes))
