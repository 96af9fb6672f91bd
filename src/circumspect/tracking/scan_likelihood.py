r"""Log-likelihood ratio of a scan at a pose in the map.

Every scan point is explained by one of three models. The reference is a uniform distribution of
points near surfaces:

- on a mapped surface: $\log((1 - \varepsilon) N(r; 0, \sigma^2) 2 d + \varepsilon)$ with the
  residual r, its standard deviation σ and the correspondence distance d,
- in space that no keyframe has seen: 0,
- in the free space of a keyframe: $\log \varepsilon$.

Each map point that the frame sees through adds $\log \varepsilon$. Neighbouring points have
correlated errors and are weighted by the inverse of `Scan.correlations`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.composition import orthonormal
from circumspect.pose_graph import KeyframeMap
from circumspect.registration import Scan, violated_count
from circumspect.registration.point_to_plane import FINE
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M
from circumspect.sensing import RgbdFrame

OUTLIER_RATIO = 0.05
"""ε: fraction of measurements that no model explains."""
MAX_DISTANCE_M = 0.05
"""d: points farther from the map than this are not on a mapped surface."""
SCAN_SAMPLE, MAP_SAMPLE = 500, 2000
"""Numbers of scan points and map points that are evaluated."""
MAX_VIOLATION_SHARE, VIOLATION_ALLOWANCE = 0.25, 3.0
"""A pose is contradicted by violations above this fraction of the support plus an allowance."""
MAX_CONFIRMED_SHARE = 0.02
"""A pose is confirmed by violations below this fraction of the support plus the allowance."""
MIN_OVERLAP = 0.5
"""Fraction of the points above the floor that must lie on the map for a lost camera to be found."""


@dataclass(frozen=True)
class ScanLikelihood:
    """Log-likelihood ratio of a scan at a pose.

    Attributes:
        support: Sum over points on mapped surfaces.
        violations: Sum over points in free space and over map points that are seen through; at
            most 0.
        overlap: Fraction of the points above the floor that lie on mapped surfaces.
        contributions: (n,) contributions of the sampled scan points to the support.
        unknown: (n,) whether each sampled point lies in unknown space.
    """

    support: float = 0.0
    violations: float = 0.0
    overlap: float = 0.0
    contributions: NDArray[np.floating] = field(default_factory=lambda: np.empty(0), repr=False)
    unknown: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, bool), repr=False)

    @property
    def total(self) -> float:
        """The log-likelihood ratio."""
        return self.support + self.violations

    @property
    def contradicts(self) -> bool:
        """Whether the scan contradicts the map at this pose."""
        return -self.violations > self._allowed(MAX_VIOLATION_SHARE)

    @property
    def confirms(self) -> bool:
        """Whether the scan agrees with the map well enough to accept a new pose."""
        return self.support >= 0 and -self.violations <= self._allowed(MAX_CONFIRMED_SHARE)

    @property
    def recognises(self) -> bool:
        """Whether the scan overlaps the map enough to relocalise a lost camera.

        A small overlap is ambiguous, as any two walls fit each other. Points in unknown space
        neither contradict nor confirm a pose.
        """
        return self.confirms and self.overlap >= MIN_OVERLAP

    def support_of_unknown(self, other: ScanLikelihood) -> float:
        """Support of the points that lie in unknown space at another pose of the same scan.

        Surfaces continue beyond the map, so that such points do not decide between the poses.
        """
        if len(self.contributions) != len(other.unknown):
            return 0.0
        return max(float(self.contributions[other.unknown].sum()), 0.0)

    def _allowed(self, share: float) -> float:
        return share * max(self.support, 0.0) + VIOLATION_ALLOWANCE


def scan_likelihood(
    frame: RgbdFrame, scan: Scan, keyframes: KeyframeMap, T_map_camera: NDArray[np.floating]
) -> ScanLikelihood:
    """Evaluate a scan at a pose.

    Args:
        frame: The frame; its depth shows which map points are seen through.
        scan: The scan of the frame.
        keyframes: The map.
        T_map_camera: (4, 4) pose to evaluate.
    """
    if len(scan) == 0 or len(keyframes.surface_map) == 0:
        return ScanLikelihood()
    step = max(1, len(scan) // SCAN_SAMPLE)
    sample = scan.subsampled(step)
    weights = step / sample.correlations
    R, t = T_map_camera[:3, :3], T_map_camera[:3, 3]
    points = sample.points_xyz @ R.T + t
    on_surface, ratios = _on_surface(points, sample.sigmas, keyframes, t)
    informative = np.ones(len(points), bool)
    if frame.T_base_camera is not None:
        # The floor looks the same everywhere: its points support no pose.
        informative = np.abs(points[:, 2]) > MAX_FLOOR_HEIGHT_M
    counted = on_surface & informative
    contributions = np.where(counted, weights * ratios, 0.0)
    overlap = float(weights[counted].sum()) / max(float(weights[informative].sum()), 1e-9)
    others = np.flatnonzero(~on_surface)
    free = keyframes.free_space_contains(points[others], T_map_camera)
    seen_through = violated_count(
        frame, keyframes.surface_map, orthonormal(T_map_camera),
        keyframes.violated, MAP_SAMPLE,
    )  # fmt: skip
    independent = float(weights.mean()) / step * seen_through
    violations = np.log(OUTLIER_RATIO) * (float(weights[others[free]].sum()) + independent)
    unknown = ~on_surface
    unknown[others[free]] = False
    return ScanLikelihood(float(contributions.sum()), violations, overlap, contributions, unknown)


def _on_surface(
    points_xyz: NDArray[np.floating],
    sigmas: NDArray[np.floating],
    keyframes: KeyframeMap,
    camera_xyz: NDArray[np.floating],
) -> tuple[NDArray[np.bool_], NDArray[np.floating]]:
    """Which points lie on mapped surfaces, and the log-likelihood ratio of each."""
    surface = keyframes.surface_map
    nearest = surface.visible_nearest(points_xyz, camera_xyz, MAX_DISTANCE_M)
    normals = surface.normals_xyz[nearest]
    residuals = np.einsum("ij,ij->i", points_xyz - surface.points_xyz[nearest], normals)
    variances = sigmas**2 + surface.sigmas[nearest] ** 2
    variances = variances + FINE.roughness_factor * surface.roughness[nearest]
    density = np.exp(-(residuals**2) / (2 * variances)) / np.sqrt(2 * np.pi * variances)
    ratios = np.log((1 - OUTLIER_RATIO) * density * 2 * MAX_DISTANCE_M + OUTLIER_RATIO)
    return nearest >= 0, ratios
