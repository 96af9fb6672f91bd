"""Where a lost camera is, by the places it has been at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry.pose_distance import distances
from circumspect.mapping.gate import GateSettings
from circumspect.registration import Registration, RegistrationSettings, Scan, SurfaceMap, register

SAMPLE = 400
"""So many points of the scan are tried at every known place."""
LOOSE = 0.1
"""A point within this distance [m] of the map speaks for a place."""
TRIED = 8
"""So many of the best places are fitted."""
SPREAD = 0.4, float(np.radians(30.0))
"""Of the places within this [m] and [rad] of each other one is fitted."""
SAME_PLACE = 0.3, float(np.radians(20.0))
"""Fits within this [m] and [rad] of each other are one place."""
NEARBY = 1.0, float(np.radians(45.0))
"""A camera that is not lost is looked for this far [m], [rad] from where it should be."""
COARSE_REACH = 0.3
"""How far points may be from their counterparts at first [m]."""
SIGMAS = np.array([np.radians(10.0)] * 3 + [0.2] * 3)
"""How far the camera may be from the place that it is compared with [rad, m]."""


@dataclass(frozen=True)
class RelocalisationSettings:
    """When a place is recognised; stricter than the gate of tracking, for nothing else vouches.

    Attributes:
        least_overlap: Share of the scan that must lie on what is known.
        least_known: The same where the rest lies where nobody looked so far.
        most_through: Share of what is known and in view that may be looked through.
        least_inliers: Share of the usual number that the frame must have: one flat piece looks
            like another.
        confirmed: So many frames in a row must tell of the same far place.
    """

    least_overlap: float = 0.88
    least_known: float = 0.5
    most_through: float = 0.01
    least_inliers: float = 0.5
    confirmed: int = 3


def relocalise(
    seen_through: Callable[[RigidTransform], float],
    scan: Scan,
    scene: SurfaceMap,
    expected: RigidTransform,
    places: list[RigidTransform],
    registration: RegistrationSettings,
    gate: GateSettings,
    settings: RelocalisationSettings,
    rest_is_news: Callable[[Registration, float], bool],
) -> list[Registration]:
    """Find a frame among known places.

    Every place is scored by how many points of the scan would lie on the map; the best ones, which
    are apart from each other, are aligned coarsely by generalised ICP (small_gicp) and then like
    any frame. Where none fits it is tried from where the camera should be.

    Args:
        seen_through: Share of the scene in view that the frame looks through from a pose.
        scan: The frame's points.
        scene: What is known.
        expected: `T_map_camera` where it should be: a wheel that slipped misleads by little.
        places: Where it may have been taken.
        registration: How it is fitted.
        gate: When to believe, as any frame …
        settings: … and beyond that.
        rest_is_news: Whether what does not lie on what is known from a fit lies where nobody
            looked so far, but for this share of what does: a robot that was bumped at the edge of
            the map sees half of it only.

    Returns:
        The registrations that fit beyond doubt, apart from each other. A scene that looks alike
        from several sides, as a square table does, has several.
    """
    if len(scan) < gate.fewest_points or len(scene) == 0:
        return []
    some = scan.points_xyz[:: max(1, len(scan) // SAMPLE)]
    scores = [float((scene.nearest(place.apply(some))[1] < LOOSE).mean()) for place in places]
    information, contrary = np.diag(SIGMAS**-2.0), 1 / settings.least_overlap - 1

    def fitted(place: RigidTransform) -> list[Registration]:
        coarse = coarsely_aligned(scan.points_xyz, scene.points_xyz, place)
        found = register(scan, scene, coarse, information, registration)
        through = seen_through(found.T_map_camera)
        verdict = gate.verdict(found, information, through, settings.least_known)
        if not verdict.is_open or through > settings.most_through:
            return []
        believed = found.overlap >= settings.least_overlap or rest_is_news(found, contrary)
        return [found] if believed else []

    ranked = [places[int(index)] for index in np.argsort(scores)[::-1]]
    best = [ranked[number] for number in _distinct(ranked, SPREAD)[:TRIED]]
    fits = [fit for place in best for fit in fitted(place)] or fitted(expected)
    fits.sort(key=lambda fit: fit.overlap, reverse=True)
    return [fits[number] for number in _distinct([fit.T_map_camera for fit in fits], SAME_PLACE)]


def coarsely_aligned(
    source_xyz: NDArray[np.float64],
    target_xyz: NDArray[np.float64],
    T_target_source: RigidTransform,
    voxel: float = 0.06,
) -> RigidTransform:
    """Generalised ICP over long distances.

    Args:
        source_xyz: (n, 3) [m].
        target_xyz: (m, 3) [m].
        T_target_source: Where to begin.
        voxel: Both are thinned to this [m].

    Returns:
        T_target_source after the alignment.

    Raises:
        InputError: Points that are not (n, 3) and finite; small_gicp would take them for none and
            return the identity.
    """
    import small_gicp

    for name, points in (("source", source_xyz), ("target", target_xyz)):
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(f"{name} points must be finite with shape (n, 3), not {points.shape}")
    result = small_gicp.align(
        np.ascontiguousarray(target_xyz, np.float64),
        np.ascontiguousarray(source_xyz, np.float64),
        np.ascontiguousarray(T_target_source.as_matrix(), np.float64),
        registration_type="GICP",
        downsampling_resolution=float(voxel),
        max_correspondence_distance=COARSE_REACH,
    )
    matrix = np.asarray(result.T_target_source)
    if result.num_inliers == 0 or not np.isfinite(matrix).all():
        return T_target_source
    return RigidTransform.from_matrix(matrix)


def within(one: RigidTransform, other: RigidTransform, bounds: tuple[float, float]) -> bool:
    """Whether two poses are less than a shift [m] and a turn [rad] from each other."""
    shift, turn = distances(one.as_matrix(), other.as_matrix())
    return bool(shift < bounds[0] and turn < bounds[1])


def nearby(places: list[RigidTransform], expected: RigidTransform) -> list[RigidTransform]:
    """Those where a camera that is not lost may be."""
    return [place for place in places if within(place, expected, NEARBY)]


def _distinct(poses: list[RigidTransform], bounds: tuple[float, float]) -> list[int]:
    """The numbers of those that are not within the bounds of one before them."""
    kept: list[int] = []
    for number, pose in enumerate(poses):
        if not any(within(pose, poses[other], bounds) for other in kept):
            kept.append(number)
    return kept
