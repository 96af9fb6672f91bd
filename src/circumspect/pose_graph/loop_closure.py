"""Covisibility of keyframes, and registration between covisible ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import distances
from circumspect.pose_graph.factors import BetweenFactor
from circumspect.pose_graph.keyframe import Keyframe
from circumspect.registration import (
    Registration,
    RegistrationSettings,
    SurfaceMap,
    register,
)
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M

LOOP_GAP = 12
"""Covisible keyframes close a loop if their numbers differ by more than this."""
COVISIBILITY_GAPS = (2, 4, LOOP_GAP)
"""A keyframe is registered to one covisible keyframe per gap, a minimum difference of numbers."""
MIN_COVISIBILITY, MAX_DEPTH_DIFFERENCE_M = 0.3, 0.15
"""Minimum fraction of the surface off the floor that a covisible keyframe shows, and maximum
difference from its measured depth [m]."""
COVISIBILITY_SAMPLE = 300
MAX_VIEW_ANGLE = float(np.radians(75.0))
"""Views that differ by more than this show different sides [rad]."""
NEIGHBOUR_SIGMAS = np.array([np.radians(0.3)] * 3 + [0.005] * 3)
LOOP_SIGMAS = np.array([np.radians(2.0)] * 3 + [0.05] * 3)
"""Prior of a loop closure's registration [rad, m]; guides the search and is then subtracted."""
VIEW_SIGMAS = np.array([np.radians(0.25)] * 3 + [0.01] * 3)
"""Error of a registration per radian between the two views [rad, m]: edges and thin parts look
different from different sides."""
MIN_VIEW_ANGLE = 0.01
MIN_INLIERS, MIN_OVERLAP, MAX_RESIDUAL = 200, 0.35, 2.5
"""Bounds of an accepted registration; the residual is in standard deviations."""
MAX_SQUARED_INNOVATION = 38.0
"""Exceeded by χ² with six degrees of freedom once in a million."""
STRIDE = 2
"""Keyframes are registered with every n-th point."""


def covisible(
    key: Keyframe, others: Sequence[Keyframe], poses: NDArray[np.floating]
) -> list[Keyframe]:
    """Select keyframes to register a new one to: the most covisible one of each gap.

    Args:
        key: The new keyframe.
        others: All other keyframes.
        poses: (n, 4, 4) `T_map_camera` of the others.
    """
    surface, T = key.surface, key.T_map_camera
    step = max(1, len(surface.scan) // COVISIBILITY_SAMPLE)
    points = surface.scan.points_xyz[::step] @ T[:3, :3].T + T[:3, 3]
    normals = surface.normals_xyz[::step] @ T[:3, :3].T
    off_floor = np.abs(points[:, 2]) > MAX_FLOOR_HEIGHT_M
    if not off_floor.any():
        return []
    points, normals = points[off_floor], normals[off_floor]
    _, angles = distances(poses, T)
    covisibilities = {
        n: float(other.shows(points, normals, MAX_DEPTH_DIFFERENCE_M).mean())
        for n, (other, angle) in enumerate(zip(others, angles, strict=True))
        if angle < MAX_VIEW_ANGLE
    }
    chosen: list[int] = []
    for gap in COVISIBILITY_GAPS:
        old = [n for n in covisibilities if key.number - others[n].number >= gap]
        best = max(old, key=lambda n: covisibilities[n], default=None)
        if best is not None and covisibilities[best] >= MIN_COVISIBILITY and best not in chosen:
            chosen.append(best)
    return [others[n] for n in chosen]


def closes_loop(first: int, second: int) -> bool:
    """Whether two keyframes are far enough apart, by their numbers, to close a loop."""
    return abs(second - first) > LOOP_GAP


def registered(
    first: Keyframe, second: Keyframe, voxel: float, settings: RegistrationSettings
) -> BetweenFactor | None:
    """Register the second keyframe to the first one.

    Args:
        first: The earlier keyframe.
        second: The later keyframe.
        voxel: Resolution of the surface map of the first [m].
        settings: Settings of the registration.

    Returns:
        The measured relative pose; None if the registration is rejected.
    """
    expected = first.relative_pose(second.T_map_camera)
    sigmas = LOOP_SIGMAS if closes_loop(first.number, second.number) else NEIGHBOUR_SIGMAS
    prior = np.diag(sigmas**-2.0)
    target = SurfaceMap(voxel).with_surface(first.surface, RigidTransform.identity())
    scan = second.surface.scan.subsampled(STRIDE)
    found = register(scan, target, RigidTransform.from_matrix(expected), prior, settings)
    if not _fits(found):
        return None
    measured, information = found.measured()
    angle = float(distances(measured, np.eye(4))[1])
    view_information = np.diag((VIEW_SIGMAS * max(angle, MIN_VIEW_ANGLE)) ** -2.0)
    return BetweenFactor(
        first.number,
        second.number,
        RigidTransform.from_matrix(measured),
        with_further_noise(information, view_information),
        robust=True,
    )


def with_further_noise(
    information: NDArray[np.floating], further: NDArray[np.floating]
) -> NDArray[np.floating]:
    """(6, 6) (C + V)⁻¹ from C⁻¹, which may be singular, and V⁻¹, which must not be."""
    return further - further @ np.linalg.solve(information + further, further)


def _fits(found: Registration) -> bool:
    return (
        found.converged
        and found.inliers >= MIN_INLIERS
        and found.overlap >= MIN_OVERLAP
        and found.normalised_residual <= MAX_RESIDUAL
        and found.squared_innovation() <= MAX_SQUARED_INNOVATION
    )
