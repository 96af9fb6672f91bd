r"""How well a scan agrees with the map at a pose, as one log-likelihood ratio.

Every scan point is explained by one of three models; the ratio is taken against chance, a uniform
distribution of points near surfaces:

- on a mapped surface: $\log((1 - \varepsilon) N(r; 0, \sigma^2) 2 d + \varepsilon)$ with the
  residual r, its standard deviation σ and the correspondence distance d,
- in space that no keyframe has seen: 0,
- in the free space of a keyframe: $\log \varepsilon$.

Map points that the frame sees through count $\log \varepsilon$ each. Neighbouring points have
correlated errors, so that each counts as the inverse of `Scan.correlations`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.composition import orthonormal
from circumspect.pose_graph import KeyframeMap
from circumspect.registration import Scan, violated_count
from circumspect.registration.point_to_plane import FINE
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M
from circumspect.sensing import RgbdFrame

OUTLIER_RATIO = 0.05
"""ε: share of measurements that no model explains."""
MAX_DISTANCE_M = 0.05
"""d: points farther from the map than this are not on a mapped surface."""
SCAN_SAMPLE, MAP_SAMPLE = 500, 2000
"""So many scan points and map points are evaluated."""
MAX_VIOLATION_SHARE, VIOLATION_ALLOWANCE = 0.25, 3.0
"""A pose is contradicted if the violations exceed this share of the support plus an allowance."""
MAX_CONFIRMED_SHARE = 0.02
"""A pose is confirmed if they are below this smaller share plus the allowance."""
MIN_OVERLAP = 0.5
"""Share of the points above the floor that must lie on the map for a lost camera to be found."""


@dataclass(frozen=True)
class ScanLikelihood:
    """Log-likelihood ratio of a scan at a pose.

    Attributes:
        support: Sum over points on mapped surfaces.
        violations: Sum over points in free space and over map points that are seen through; not
            positive.
        overlap: Share of the points above the floor that lie on mapped surfaces.
    """

    support: float = 0.0
    violations: float = 0.0
    overlap: float = 0.0

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
        """Whether the scan agrees with the map so well that a new pose may be assumed."""
        return -self.violations <= self._allowed(MAX_CONFIRMED_SHARE)

    @property
    def recognises(self) -> bool:
        """Whether the scan shows so much of the map that a lost camera may be found there.

        Any two walls fit each other. What lies in unknown space contradicts no pose, and confirms
        none.
        """
        return self.confirms and self.overlap >= MIN_OVERLAP

    def _allowed(self, share: float) -> float:
        return share * max(self.support, 0.0) + VIOLATION_ALLOWANCE


def scan_likelihood(
    frame: RgbdFrame, scan: Scan, keyframes: KeyframeMap, T_map_camera: NDArray[np.floating]
) -> ScanLikelihood:
    """Evaluate a scan at a pose.

    Args:
        frame: The frame, for what it sees through.
        scan: Its points.
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
    telling = np.ones(len(points), bool)
    if frame.T_base_camera is not None:
        # The floor looks alike everywhere: its points support no pose.
        telling = np.abs(points[:, 2]) > MAX_FLOOR_HEIGHT_M
    counted = on_surface & telling
    support = float((weights * ratios)[counted].sum())
    overlap = float(weights[counted].sum()) / max(float(weights[telling].sum()), 1e-9)
    others = np.flatnonzero(~on_surface)
    free = keyframes.free_space_contains(points[others], T_map_camera)
    seen_through = violated_count(
        frame, keyframes.surface_map, orthonormal(T_map_camera),
        keyframes.violated, MAP_SAMPLE,
    )  # fmt: skip
    independent = float(weights.mean()) / step * seen_through
    violations = np.log(OUTLIER_RATIO) * (float(weights[others[free]].sum()) + independent)
    return ScanLikelihood(support, violations, overlap)


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
