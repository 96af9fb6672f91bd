"""Relocalisation: candidate poses of a camera that may be anywhere in the map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import distances
from circumspect.motion import PoseWithCovariance
from circumspect.pose_graph import KeyframeMap
from circumspect.registration import Scan

SCAN_SAMPLE = 400
MAX_DISTANCE_M = 0.1
"""A keyframe's score is the fraction of so many scan points within this distance of the map [m]."""
MAX_CANDIDATES = 8
MIN_SEPARATION_M, MIN_SEPARATION_ROTATION = 0.4, float(np.radians(30.0))
"""Minimum distance between the keyframes from which candidates start [m], [rad]."""
START_SIGMAS = np.array([np.radians(10.0)] * 3 + [0.2] * 3)
"""Standard deviations of a candidate pose [rad, m]."""
COARSE_VOXEL_M, COARSE_DISTANCE_M = 0.06, 0.3
"""Resolution and correspondence distance of the coarse alignment [m]."""


def is_vague(pose: PoseWithCovariance) -> bool:
    """Whether a pose is more uncertain than a candidate pose."""
    rotation, translation = pose.sigmas
    return rotation > START_SIGMAS[0] or translation > START_SIGMAS[3]


def candidate_poses(scan: Scan, keyframes: KeyframeMap) -> list[PoseWithCovariance]:
    """Candidate poses of a scan, near keyframes.

    Every keyframe is scored by the number of scan points that would lie on the map. The scan is
    then aligned coarsely by generalised ICP (small_gicp), starting at the best keyframes that are
    apart from each other.

    Args:
        scan: The scan.
        keyframes: The map.

    Returns:
        At most `MAX_CANDIDATES`, the best keyframe first.
    """
    if len(scan) == 0 or len(keyframes) == 0:
        return []
    sample = scan.points_xyz[:: max(1, len(scan) // SCAN_SAMPLE)]
    surface = keyframes.surface_map
    scores = [
        float((surface.nearest(sample @ T[:3, :3].T + T[:3, 3])[1] < MAX_DISTANCE_M).mean())
        for T in keyframes.poses
    ]
    ranked = [keyframes.poses[index] for index in np.argsort(scores)[::-1]]
    covariance = np.diag(START_SIGMAS**2)
    return [
        PoseWithCovariance(_aligned(scan.points_xyz, surface.points_xyz, T), covariance)
        for T in _separated(ranked)[:MAX_CANDIDATES]
    ]


def _separated(poses: Sequence[NDArray[np.floating]]) -> list[NDArray[np.floating]]:
    """Poses that are not near an earlier one."""
    kept: list[NDArray[np.floating]] = []
    for pose in poses:
        if kept:
            translation, rotation = distances(np.stack(kept), pose)
            if ((translation < MIN_SEPARATION_M) & (rotation < MIN_SEPARATION_ROTATION)).any():
                continue
        kept.append(pose)
    return kept


def _aligned(
    source_xyz: NDArray[np.floating],
    target_xyz: NDArray[np.floating],
    T_target_source: NDArray[np.floating],
) -> NDArray[np.floating]:
    """(4, 4) `T_target_source` after generalised ICP; the initial one if nothing corresponds."""
    import small_gicp

    result = small_gicp.align(
        np.ascontiguousarray(target_xyz, np.float64),
        np.ascontiguousarray(source_xyz, np.float64),
        np.ascontiguousarray(T_target_source, np.float64),
        registration_type="GICP",
        downsampling_resolution=COARSE_VOXEL_M,
        max_correspondence_distance=COARSE_DISTANCE_M,
    )
    matrix = np.asarray(result.T_target_source)
    if result.num_inliers == 0 or not np.isfinite(matrix).all():
        return T_target_source
    return RigidTransform.from_matrix(matrix).as_matrix()
