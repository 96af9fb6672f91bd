"""Linearisation of the point-to-plane problem."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from circumspect.registration.scan import Scan
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M
from circumspect.registration.surface_map import MAX_BACKFACE_COSINE, SurfaceMap

TUKEY_CUTOFF = 4.685
"""Normalised residuals beyond this have weight 0 (95 % efficiency for normal noise)."""
MIN_NOISE_SCALE = 0.2
"""Lower bound of the noise scale that is estimated from the residuals. 1 is the sensor's noise."""
MIN_POINTS_OFF_FLOOR = 100
"""With at least this many points off the floor, overlap and distance are computed from them."""
MAX_PLANE_DISTANCE_M = 0.02
"""Upper bound of a point's distance to the map's planes [m] in the mean distance."""
MIN_CORRESPONDENCES = 6
"""With fewer correspondences the problem is empty."""
SPURIOUS_FACTOR = 1.5
"""This multiple of the expected spurious information is subtracted."""
RIDGE_INFORMATION = 1.0
"""Negligible information [1/m², 1/rad²]; regularises the spurious information."""


@dataclass(frozen=True)
class Weighting:
    """Weights of the residuals.

    Attributes:
        correlation_factor: Multiple of `Scan.correlations`.
        roughness_factor: Multiple of the map's roughness that is added to the variance of the
            sensor noise.
        min_cutoff: Lower bound of the cut-off, in units of `TUKEY_CUTOFF` standard deviations of
            the sensor noise.
    """

    correlation_factor: float
    roughness_factor: float
    min_cutoff: float


COARSE = Weighting(correlation_factor=3.5, roughness_factor=0.0, min_cutoff=1.0)
"""Weights far from the optimum: rims show the direction, large residuals are no outliers yet."""
FINE = Weighting(correlation_factor=1.0, roughness_factor=3.0, min_cutoff=0.0)
"""Weights at the optimum, and for its information. Planes at rims are fitted to both sides, so that
their error is far larger than the sensor noise."""


@dataclass(frozen=True, eq=False)
class PointToPlaneProblem:
    """The point-to-plane problem, linearised at one pose.

    Attributes:
        hessian: (6, 6) of half the sum of weighted squares.
        spurious: (6, 6) spurious information: what noise of the normals is expected to add to the
            Hessian.
        gradient: (6,) of half the sum of weighted squares.
        inliers: See `Registration`, also for the next attributes.
        overlap: Fraction of the points that have a correspondence.
        distance: Mean distance to the map's planes [m].
        residual: Root mean square distance of the inliers [m].
        normalised_residual: The same in standard deviations of the sensor noise.
    """

    hessian: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    spurious: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    gradient: NDArray[np.float64] = field(default_factory=lambda: np.zeros(6))
    inliers: int = 0
    overlap: float = 0.0
    distance: float = MAX_PLANE_DISTANCE_M
    residual: float = 0.0
    normalised_residual: float = 0.0

    def without_spurious_information(self) -> PointToPlaneProblem:
        """The problem without the information that noise of the normals adds.

        On a bare wall, noise of the normals acts like a texture and adds information along the
        wall. Let H be the Hessian and S the spurious information. In directions v with
        H v = λ S v, λ - `SPURIOUS_FACTOR` of λ is kept, or nothing if that is negative. There the
        prior alone determines the pose. This follows Zhang, Kaess and Singh, "On degeneracy of
        optimization-based state estimation problems" (2016), who use a constant threshold.
        """
        S = self.spurious + RIDGE_INFORMATION * np.eye(6)
        values, W = eigh(self.hessian, S, check_finite=False)  # Wᵀ S W = I
        kept = np.maximum(values - SPURIOUS_FACTOR, 0.0)
        V = S @ W
        fraction = kept / np.maximum(values, SPURIOUS_FACTOR)
        gradient = V @ (fraction * (W.T @ self.gradient))
        return replace(self, hessian=(V * kept) @ V.T, gradient=gradient)


def linearised(
    scan: Scan,
    surface_map: SurfaceMap,
    T: NDArray[np.float64],
    max_distance: float,
    weighting: Weighting = FINE,
) -> PointToPlaneProblem:
    """Linearise the point-to-plane problem at one pose.

    The computation is in C++. The tests compare it with a reference in NumPy.

    Args:
        scan: The scan.
        surface_map: The map.
        T: (4, 4) `T_map_camera`.
        max_distance: Maximum correspondence distance [m].
        weighting: Weights of the residuals.

    Returns:
        The problem; without inliers if there are fewer than `MIN_CORRESPONDENCES`.
    """
    if len(scan) == 0 or len(surface_map) == 0:
        return PointToPlaneProblem()
    return PointToPlaneProblem(
        *surface_map.planes.linearised(
            scan.points_xyz,
            scan.sigmas,
            scan.correlations,
            T,
            max_distance=max_distance,
            tukey_cutoff=TUKEY_CUTOFF,
            correlation_factor=weighting.correlation_factor,
            min_noise_scale=MIN_NOISE_SCALE,
            roughness_factor=weighting.roughness_factor,
            min_cutoff=weighting.min_cutoff,
            max_floor_height=MAX_FLOOR_HEIGHT_M,
            max_plane_distance=MAX_PLANE_DISTANCE_M,
            max_backface_cosine=MAX_BACKFACE_COSINE,
            min_points_off_floor=MIN_POINTS_OFF_FLOOR,
            min_correspondences=MIN_CORRESPONDENCES,
        )
    )
