from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import (
    SHORT,
    blind,
    drive,
    follow,
    place_errors,
    short_drive,
    true_base,
    true_camera,
)

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose, se3
from circumspect.mapping import (
    GATE_OPEN,
    PoseEstimate,
    RegisteredPoses,
    TrackingSettings,
    registered_poses,
)
from circumspect.mapping.keyframes import KeyframeSettings
from circumspect.mapping.registered_poses import RECOGNISED, STANDING, STEADY
from circumspect.registration import Registration, Scan, register
from circumspect.sensing import RgbdFrame

NEAR = 0.03
"""A place that is called certain is no further off than this [m], small pictures considered."""


def never_wrong_and_sure(estimates: list, angles: np.ndarray) -> None:
    errors = place_errors(estimates, angles)
    sure = np.array([estimate.certain for estimate in estimates])
    assert errors[sure].max() < NEAR


def with_odometry(frames, change) -> list:
    """Frames whose odometry pose goes through `change(number, pose)`."""
    changed = []
    for number, frame in enumerate(frames):
        pose = change(number, frame.odometry.T_odom_base)
        odometry = None if pose is None else replace(frame.odometry, T_odom_base=pose)
        changed.append(replace(frame, odometry=odometry))
    return changed


def test_a_drive_is_followed_better_than_by_the_wheels() -> None:
    frames = short_drive()
    told = follow(frames)
    assert {estimate.gate for estimate in told} == {GATE_OPEN}
    assert {estimate.prior for estimate in told[1:]} == {"odometry"}
    errors = place_errors(told, SHORT)
    wheels = frames[-1].odometry.T_odom_base.xy
    true = (true_base(float(SHORT[0])).inverse() @ true_base(float(SHORT[-1]))).xy
    assert errors.max() < 0.02 < np.linalg.norm(wheels - true)
    for estimate, frame in zip(told, frames, strict=True):
        again = estimate.T_map_odom @ frame.odometry.T_odom_base
        np.testing.assert_allclose(again.xy, estimate.T_map_base.xy, atol=1e-9)
        assert (np.linalg.eigvalsh(estimate.covariance) > 0).all()


def test_the_map_is_the_odom_frame_at_the_first_frame() -> None:
    first = RegisteredPoses().estimate(short_drive()[0])
    assert first.T_map_odom is not None
    np.testing.assert_allclose([*first.T_map_odom.xy, first.T_map_odom.yaw], 0, atol=1e-12)


def test_a_common_motion_of_the_odometry_moves_all_poses() -> None:
    """Fusion is equivariant: it does not matter where the odom frame lies."""
    G = PlanarPose(2.01, -0.99, np.pi / 2)  # whole voxels of the map
    frames = short_drive()[:5]
    one = follow(frames)
    other = follow(with_odometry(frames, lambda _, pose: G @ pose))
    for a, b in zip(one, other, strict=True):
        difference = se3.log((G.as_transform() * a.T_map_camera).inv() * b.T_map_camera)
        assert np.abs(difference).max() < 1e-3


def test_without_odometry_the_first_pose_must_be_given() -> None:
    frame = replace(short_drive()[0], odometry=None, T_base_camera=None)
    with pytest.raises(InputError, match="needs the pose of the first frame"):
        RegisteredPoses().estimate(frame)
    given = RegisteredPoses(RigidTransform.identity()).estimate(frame)
    np.testing.assert_allclose(given.T_map_camera.as_matrix(), np.eye(4), atol=1e-12)


def test_a_robot_whose_wheels_are_mute_begins_its_map_where_it_stands() -> None:
    frame = replace(short_drive()[0], odometry=None)
    first = RegisteredPoses().estimate(frame)
    mount = frame.T_base_camera
    assert mount is not None
    np.testing.assert_allclose(first.T_map_camera.as_matrix(), mount.as_matrix(), atol=1e-12)
    assert first.T_map_base is not None
    np.testing.assert_allclose([*first.T_map_base.xy, first.T_map_base.yaw], 0, atol=1e-12)


def test_a_camera_without_a_robot_is_followed_by_constant_velocity() -> None:
    start = true_camera(float(SHORT[0]))
    frames = [replace(frame, odometry=None, T_base_camera=None) for frame in short_drive()]
    told = follow(frames, RegisteredPoses(start))
    assert {estimate.prior for estimate in told[1:]} <= {"constant velocity", RECOGNISED}
    assert {(e.T_map_base, e.T_map_odom) for e in told} == {(None, None)}
    never_wrong_and_sure(told, SHORT)
    assert told[-1].certain


@pytest.mark.parametrize("start_deg", [200.0, 300.0])
def test_a_camera_without_wheels_may_stop_at_once(start_deg: float) -> None:
    """Fitted from where the last motion would lead to, a frame slides along a flat side."""
    steps = np.concatenate([np.full(5, 2.5), np.full(5, 12.0), np.zeros(3)])
    angles = np.radians(start_deg + np.concatenate([[0.0], np.cumsum(steps)]))
    told = follow([replace(frame, odometry=None) for frame in drive(angles)])
    assert STANDING in {estimate.prior for estimate in told}
    errors = place_errors(told, angles)
    assert errors.max() < 0.06
    # Seen anew from 30 cm further on each time, flat sides hold it to 20 to 30 mm, as is told.
    for estimate, error in zip(told, errors, strict=True):
        assert error < max(NEAR, 2 * estimate.deviations[1]) or not estimate.certain


def test_a_blackout_is_bridged_by_odometry_with_growing_covariance() -> None:
    frames = [blind(f) if 6 <= n < 11 else f for n, f in enumerate(short_drive())]
    told = follow(frames)
    dark, sizes = told[6:11], [np.linalg.det(e.covariance[3:, 3:]) for e in told[5:11]]
    assert all(e.gate == "0 points in range; 300 are needed" for e in dark)
    assert (np.diff(sizes) > 0).all()
    assert told[11].gate == GATE_OPEN
    never_wrong_and_sure(told, SHORT)


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_depth_in_the_wrong_unit_closes_the_gate(factor: float) -> None:
    frames = list(short_drive()[:6])
    frames[3] = replace(frames[3], depth=frames[3].depth * factor)
    told = follow(frames)
    assert told[3].gate == "0 points in range; 300 are needed"
    assert told[4].gate == GATE_OPEN
    never_wrong_and_sure(told, SHORT[:6])


@pytest.mark.parametrize("kind", ["gone", "stuck", "jumping"])
def test_odometry_that_fails_does_not_mislead(kind: str) -> None:
    stuck = short_drive()[5].odometry.T_odom_base
    jump = PlanarPose(0.4, -0.3, 0.5)
    changes = {
        "gone": lambda n, pose: None if n >= 5 else pose,
        "stuck": lambda n, pose: stuck if n >= 5 else pose,
        "jumping": lambda n, pose: jump @ pose if n >= 8 else pose,
    }
    told = follow(with_odometry(short_drive(), changes[kind]))
    never_wrong_and_sure(told, SHORT)
    assert told[8].prior == "constant velocity"
    assert told[-1].certain


def test_before_news_less_of_a_frame_must_be_known_to_find_it_near_by(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As much as of the last ones; a camera that is lost is found by more."""
    asked = []

    def nowhere(*given: Any) -> list[Registration]:
        asked.append(given[7].least_known)
        return []

    monkeypatch.setattr(registered_poses, "relocalise", nowhere)
    poses = RegisteredPoses()
    frames = [*short_drive()[:6], *drive(np.radians(180 + np.arange(4) * 2.5))]
    for number, frame in enumerate(frames):
        if number == 6:
            poses._usual.overlap = 0.7
        poses.estimate(frame)
    s = poses.settings
    assert asked[0] == pytest.approx(0.7 * s.keeps_overlap)
    assert asked[s.lost_after - 1 :] == [s.relocalisation.least_known] * (5 - s.lost_after)


@pytest.mark.parametrize("certain", [(1e-9, 1.0), (1.0, 1e-9)])
def test_turn_and_place_must_both_be_known_to_be_certain(certain: tuple[float, float]) -> None:
    strict = RegisteredPoses(settings=replace(TrackingSettings(), certain=certain))
    told = follow(short_drive()[:3], strict)[1:]
    assert not any(estimate.certain for estimate in told)
    limit = r"57.3° and 0 mm" if certain[0] == 1.0 else r"0.0° and 1000 mm"
    known = rf"known to [\d.]+° and \d+ mm; {limit} are needed"
    assert all(re.fullmatch(known, estimate.doubt) for estimate in told)
    generous = RegisteredPoses(settings=replace(TrackingSettings(), certain=(1.0, 1.0)))
    assert all(estimate.certain for estimate in follow(short_drive()[:3], generous))


def after_a_blind_passage(end_deg: float, off: float) -> PoseEstimate:
    """The drive goes on blindly to an azimuth, where the wheels are off by so much [m]."""
    angles = np.concatenate([SHORT, np.radians(np.arange(60.0, end_deg + 1, 2.5))])
    frames = drive(angles)
    odometry, unsure = frames[-1].odometry, np.diag([2 * off, 2 * off, off / 5]) ** 2
    there = replace(odometry.T_odom_base, x=odometry.T_odom_base.x + off)
    told = replace(odometry, T_odom_base=there, covariance=odometry.covariance + unsure)
    frames[-1] = replace(frames[-1], odometry=told)
    blinded = map(blind, frames[len(SHORT) : -1])
    return follow([*frames[: len(SHORT)], *blinded, frames[-1]])[-1]


def test_news_speaks_for_a_pose_only_where_it_is_known_already() -> None:
    assert after_a_blind_passage(100, off=0.0).gate == GATE_OPEN
    lost = after_a_blind_passage(180, off=0.1)
    assert "lie on what is known" in lost.gate
    assert not lost.certain


def test_after_a_vague_pose_most_of_a_frame_must_be_known() -> None:
    """Two blind frames without odometry; what comes then shows little of what was seen before."""
    frames = drive(np.concatenate([SHORT, np.radians([60.0, 62.5, 120.0])]))
    mute = with_odometry(frames[16:], lambda *_: None)
    told = follow([*frames[:16], blind(mute[0]), blind(mute[1]), mute[2]])
    assert "70% are needed" in told[-1].gate
    assert not told[-1].certain


@pytest.mark.parametrize("why", ["is_ambiguous", "is_hasty"])
def test_a_fit_that_is_refused_is_told_as_it_was(why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The prediction stands, but who reads the log sees what the frame said."""
    monkeypatch.setattr(f"circumspect.mapping.placement.{why}", lambda *_: True)
    told = follow(short_drive()[:3])[-1]
    assert told.gate in ("fits elsewhere as well", "far from where it was expected")
    assert told.converged
    assert told.inliers > 1000
    assert 0 < told.residual < 0.02
    assert told.remark.startswith(told.gate)


@pytest.fixture
def sizes(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Points of each scan that is fitted to the scene."""
    counts: list[int] = []

    def counted(scan: Scan, *rest: Any) -> Registration:
        counts.append(len(scan))
        return register(scan, *rest)

    monkeypatch.setattr("circumspect.mapping.placement.register", counted)
    return counts


def test_a_further_prediction_that_fits_no_better_gets_a_glance(sizes: list[int]) -> None:
    """A robot that stops at once: as if it had driven on, it fits no better than by the wheels."""
    told = follow(drive(np.concatenate([SHORT, SHORT[-1:]])))
    assert told[-1].prior == "odometry"
    assert told[-1].gate == GATE_OPEN
    by_wheels, glance = sizes[-2:]
    assert glance == pytest.approx(by_wheels / 3, abs=1)


def test_a_further_prediction_that_fits_better_is_looked_at_closely(sizes: list[int]) -> None:
    """Wheels that leapt once are believed again only where they fit clearly better."""
    leaps = {14: PlanarPose(0.0, 0.12, 0.0), 15: PlanarPose(0.0, 0.16, 0.0)}
    frames = with_odometry(short_drive(), lambda n, pose: pose @ leaps.get(n, PlanarPose()))
    told = follow(frames)
    assert told[-1].prior == STEADY
    by_wheels, glance, closely = sizes[-3:]
    assert by_wheels == closely > glance
    never_wrong_and_sure(told, SHORT)


def test_dropped_frames_are_bridged() -> None:
    kept = [0, 1, 2, 4, 5, 8, 9, 12, 15]
    told = follow([short_drive()[n] for n in kept])
    never_wrong_and_sure(told, SHORT[kept])
    assert all(estimate.certain for estimate in told)


def carried_off(angle: float, count: int = 8) -> tuple[list, np.ndarray]:
    """A drive, and from its end on frames from elsewhere that the wheels know nothing of."""
    away = np.radians(angle + np.arange(count) * 2.5)
    frames = [*short_drive(), *drive(away)]
    last = frames[15].odometry.T_odom_base
    moved = with_odometry(frames, lambda n, pose: last @ pose if n >= 16 else pose)
    stamped = [replace(frame, stamp=float(n)) for n, frame in enumerate(moved)]
    return stamped, np.concatenate([SHORT, away])


def test_a_kidnapped_robot_is_noticed_where_nothing_is_known() -> None:
    frames, angles = carried_off(190.0)
    told = follow(frames)
    assert not any(estimate.certain for estimate in told[16:])
    assert all(estimate.gate != GATE_OPEN for estimate in told[16:])
    assert told[-1].gate.startswith("lost: ")
    assert told[-1].doubt == "8 frames contradicted what is known"
    never_wrong_and_sure(told, angles)


def test_a_camera_found_again_is_on_probation_and_says_so() -> None:
    told = after_a_blind_passage(100, off=0.0)
    assert told.gate == GATE_OPEN
    assert told.doubt == "2 frames must agree first"


def test_a_kidnapped_robot_finds_back_to_a_place_it_knows() -> None:
    frames, angles = carried_off(0.0)
    told = follow(frames)
    assert RECOGNISED in {estimate.prior for estimate in told[16:]}
    assert told[-1].certain
    never_wrong_and_sure(told, angles)


def almost_blind(frame: RgbdFrame, pixels: int = 24) -> RgbdFrame:
    """Depth in one corner of the picture only, as behind a hand or before a window."""
    depth = np.full(frame.depth.shape, np.nan)
    depth[:pixels, :pixels] = frame.depth[:pixels, :pixels]
    return replace(frame, depth=depth)


@pytest.mark.parametrize("hidden", [blind, almost_blind])
def test_frames_that_say_nothing_remove_no_doubt(hidden: Callable[[RgbdFrame], RgbdFrame]) -> None:
    frames, angles = carried_off(190.0)
    told = follow([*frames[:17], *map(hidden, frames[17:])])
    assert all("300 are needed" in estimate.gate for estimate in told[17:])
    assert not any(estimate.certain for estimate in told[16:])
    never_wrong_and_sure(told, angles)


def test_without_a_doubt_a_frame_that_says_nothing_changes_no_trust() -> None:
    told = follow([*short_drive()[:6], almost_blind(short_drive()[6])])
    assert "300 are needed" in told[-1].gate
    assert told[-1].certain


def test_a_kidnapped_robot_is_found_though_every_second_frame_says_nothing() -> None:
    frames, angles = carried_off(0.0, count=15)
    away = [blind(f) if n % 2 else f for n, f in enumerate(frames[16:])]
    told = follow([*frames[:16], *away])
    assert RECOGNISED in {estimate.prior for estimate in told[16:]}
    assert told[-1].certain
    never_wrong_and_sure(told, angles)


def test_a_round_is_closed_and_corrected() -> None:
    angles = np.radians(np.arange(45, 430, 5.0))
    poses = RegisteredPoses()
    told = follow(drive(angles), poses)
    poses.settle()
    final = [e.at(T) for e, T in zip(told, poses.corrected(told), strict=True)]
    assert poses.corrections > 0
    assert poses.keyframes.loops > 0
    corrections = poses.corrections
    poses.settle()
    assert poses.corrections == corrections  # no frame came since
    assert place_errors(final, angles).max() < NEAR
    # A common frame: the end lies where the beginning lay.
    assert place_errors(final, angles)[-1] < 0.02


def test_whenever_the_map_grows_the_poses_are_the_same() -> None:
    """At once, or only when the next frame comes; and what was told before does not change."""
    frames, poses = short_drive(), RegisteredPoses()
    at_once = []
    for frame in frames:
        told = poses.estimate(frame)
        before = len(poses.keyframes), poses.corrected([told])[0].as_matrix()
        poses.catch_up()
        np.testing.assert_array_equal(poses.corrected([told])[0].as_matrix(), before[1])
        at_once.append((told, len(poses.keyframes) - before[0]))
    assert sum(grown for _, grown in at_once) >= 1
    for (one, _), other in zip(at_once, follow(frames), strict=True):
        np.testing.assert_array_equal(one.T_map_camera.as_matrix(), other.T_map_camera.as_matrix())
        np.testing.assert_array_equal(one.covariance, other.covariance)


def test_keyframes_stay_few_and_what_hung_on_them_stays_placed() -> None:
    settings = TrackingSettings(keyframes=KeyframeSettings(shift=0.05, turn=0.05, most=5))
    poses = RegisteredPoses(settings=settings)
    told = follow(short_drive(), poses)
    poses.settle()
    assert len(poses.keyframes) == 5
    final = [e.at(T) for e, T in zip(told, poses.corrected(told), strict=True)]
    assert place_errors(final, SHORT).max() < NEAR
