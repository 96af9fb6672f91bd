"""Which keyframes are fitted to each other, and what such a fit is worth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.geometry.composition import between, composed
from circumspect.geometry.pose_distance import distances
from circumspect.mapping.gate import GateSettings
from circumspect.mapping.keyframe import Keyframe
from circumspect.mapping.wheel_grip import WheelGrip
from circumspect.mapping.wheels import Passage
from circumspect.pose_graph import BetweenFactor
from circumspect.registration import RegistrationSettings, SurfaceMap, register
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M

OLD = 12
"""Keyframes so many apart in number that show the same close a loop."""
AGES = (2, 3, 4, 6, OLD)
"""A keyframe is fitted to the last one, and to one at least so many before it each."""
ASKED, SAME, SHOWN = 300, 0.15, 0.3
"""Of so many points of a keyframe this share must lie where an old one saw something, up to this
distance along its line of sight [m]."""
TURNED = float(np.radians(75.0))
"""Views that differ by more [rad] show other sides of things."""
TRACKED_SIGMAS, TOO_SURE = np.array([np.radians(0.03)] * 3 + [0.0005] * 3), 1.5
"""From one keyframe to the next tracking is taken to err by so much [rad, m], and by so many of the
standard deviations that the scene's Hessian tells: cautiously, see docs/derivations.md."""
BELIEVED_SIGMAS = np.array([np.radians(2.0)] * 3 + [0.05] * 3)
"""How far others may be from where they are believed to be."""
VIEW_SIGMAS = np.array([np.radians(0.25)] * 3 + [0.01] * 3)
"""By so much [rad, m] a fit of two keyframes errs for each radian between their views."""
BETTER = 0.9
"""At this share of the mean distance to each other two keyframes fit clearly better."""
PAIR_THINNED = 2
"""Every second point is enough to fit two keyframes to each other."""


def showing_the_same(
    key: Keyframe, others: Sequence[Keyframe], poses: NDArray[np.float64]
) -> list[int]:
    """Of each age the keyframe that shows most of what a new one shows, if it shows enough.

    Args:
        key: The new one.
        others: All others.
        poses: (n, 4, 4) `T_map_camera` of the others.

    Returns:
        Their numbers.
    """
    surface, matrix = key.surface, key.T_map_camera.as_matrix()
    step = max(1, len(surface.scan) // ASKED)
    points = surface.scan.points_xyz[::step] @ matrix[:3, :3].T + matrix[:3, 3]
    normals = surface.normals_xyz[::step] @ matrix[:3, :3].T
    off = np.abs(points[:, 2]) > MAX_FLOOR_HEIGHT_M
    if not off.any():
        return []
    _, turns = distances(poses, matrix)
    shares = {
        other.number: float(other.shows(points[off], normals[off], SAME).mean())
        for other, turn in zip(others, turns, strict=True)
        if turn < TURNED
    }
    chosen = []
    for least in AGES:
        old = [number for number in shares if key.number - number >= least]
        best = max(old, key=lambda number: shares[number], default=None)
        if best is not None and shares[best] >= SHOWN and best not in chosen:
            chosen.append(best)
    return chosen


def pair_edge(
    one: Keyframe,
    other: Keyframe,
    voxel: float,
    registration: RegistrationSettings,
    gate: GateSettings,
    grip: WheelGrip,
) -> BetweenFactor | None:
    """Fit two keyframes to each other.

    Args:
        one: The earlier one.
        other: The later one.
        voxel: Of the map that the earlier one makes [m].
        registration: How they are fitted.
        gate: What is believed.
        grip: What the wheels are worth.

    Returns:
        What is known then; None where that is nothing. Consecutive keyframes are never let go,
        but where a frame between them contradicted: what they do not tell of each other, tracking
        and the wheels do.
    """
    expected = between(one.T_map_camera, other.T_map_camera)
    consecutive = is_consecutive(one.number, other.number)
    loop = closes_a_loop(one.number, other.number)
    # Both were fitted to the same map, from frame to frame.
    tracked = one.passage.stretch == other.passage.stretch and not loop
    broken = consecutive and other.passage.broken
    believed = by_tracking(one, other) if tracked else np.diag(BELIEVED_SIGMAS**-2.0)
    guesses = [(expected, believed)]
    if consecutive and not tracked:
        guesses = [along(other.passage, expected, gate, grip), *(guesses if broken else [])]
    target = SurfaceMap(voxel).with_surface(one.surface, RigidTransform.identity())
    thinned = other.surface.scan.subsampled(PAIR_THINNED)
    fits = [register(thinned, target, T, known, registration) for T, known in guesses]
    # The wheels may have misled, or the pose leapt: what the two keyframes show decides.
    best = len(fits) - 1 if fits[-1].distance < BETTER * fits[0].distance else 0
    found, (expected, believed) = fits[best], guesses[best]
    verdict = gate.verdict(found, believed)
    measured, known = found.T_map_camera, found.information
    if consecutive:
        if verdict.contradicts:
            measured, known = expected, believed
    elif not verdict.is_open:
        return None
    elif not tracked:
        known = found.hessian
    worth = worth_by_view(known, measured)
    return BetweenFactor(
        one.number, other.number, measured, worth, robust=broken or not consecutive
    )


def by_tracking(one: Keyframe, other: Keyframe) -> NDArray[np.float64]:
    """(6, 6) information of tracking alone about two keyframes of one stretch.

    Of each step it is off by `TRACKED_SIGMAS`, and by more where the scene hardly held it.
    """
    steps = max(other.number - one.number, 1)
    step = np.diag(TRACKED_SIGMAS**-2.0)
    by_scene = other.passage.by_scene
    if by_scene is not None:
        step = blurred(by_scene / TOO_SURE**2, step)
    return step / steps


def along(
    passage: Passage, T_live: RigidTransform, gate: GateSettings, grip: WheelGrip
) -> tuple[RigidTransform, NDArray[np.floating]]:
    """What a passage on which the scene did not hold tells of its end, with its information.

    After a broken one the camera was found again, perhaps elsewhere. It was not where the wheels,
    with all that they may be off, lead there, too.
    """
    believed = T_live, np.diag(BELIEVED_SIGMAS**-2.0)
    if passage.by_wheels is None:
        return believed
    wheels, by_scene = passage.by_wheels.by(grip), passage.by_scene
    T, information = wheels.T_map_camera, np.linalg.inv(wheels.covariance)
    off = se3.log(between(T, T_live))
    if passage.broken and off @ information @ off < gate.farthest:
        return believed
    return (T, information) if by_scene is None else joined(T, information, T_live, by_scene)


def joined(
    T: RigidTransform,
    information: NDArray[np.floating],
    T_other: RigidTransform,
    other_information: NDArray[np.floating],
) -> tuple[RigidTransform, NDArray[np.floating]]:
    """Two measurements of the same pose by their information; one may be blind to a direction.

    With e = log(T⁻¹T_other) and information Λ, H the joint optimum lies at T exp((Λ + H)⁻¹He).
    """
    total = information + other_information
    step = np.linalg.solve(total, other_information @ se3.log(between(T, T_other)))
    return composed(T, se3.exp(step)), total


def is_consecutive(first: int, second: int) -> bool:
    """Whether a keyframe was the next one after another, by their numbers."""
    return second - first == 1


def closes_a_loop(first: int, second: int) -> bool:
    """Whether two keyframes were taken long after each other, by their numbers."""
    return second - first > OLD


def worth_by_view(
    information: NDArray[np.floating], T_first_second: RigidTransform
) -> NDArray[np.float64]:
    """What a fit is worth: with covariance C it is (C + V)⁻¹, where V grows with the turn.

    From different sides rims and thin parts look different, and the fit errs by more than noise.

    Args:
        information: (6, 6) C⁻¹, perhaps singular.
        T_first_second: What was fitted.

    Returns:
        (6, 6).
    """
    return blurred(information, np.linalg.inv(view_covariance(T_first_second)))


def blurred(
    information: NDArray[np.floating], further: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(6, 6) (C + V)⁻¹ of C⁻¹, which may be blind to a direction, and V⁻¹, which may not."""
    return further - further @ np.linalg.solve(information + further, further)


def view_covariance(T_first_second: RigidTransform) -> NDArray[np.float64]:
    """(6, 6) V: what things that look different from two sides add to the covariance of a fit."""
    turn = float(distances(T_first_second.as_matrix(), np.eye(4))[1])
    return np.diag((VIEW_SIGMAS * max(turn, 1e-2)) ** 2)
