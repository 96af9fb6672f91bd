"""The tracker on drives round a box: accuracy, faults, kidnapping, corrections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import (
    SETTINGS,
    SHORT,
    SQUARE,
    SURFACES,
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
from circumspect.pose_graph import KeyframeSettings
from circumspect.sensing import RgbdFrame
from circumspect.simulation import Surface, block
from circumspect.tracking import PoseEstimate, Tracker, TrackingState

NEAR = 0.03
"""A reliable pose is no further off than this [m] or three standard deviations."""
OdometryChange = Callable[[int, PlanarPose], PlanarPose | None]


def assert_reliable_poses_are_right(estimates: list[PoseEstimate], angles: np.ndarray) -> None:
    for estimate, error in zip(estimates, place_errors(estimates, angles), strict=True):
        assert estimate.sigmas is not None
        assert not estimate.reliable or error < max(NEAR, 3 * estimate.sigmas[1])


def with_odometry(frames: list[RgbdFrame], change: OdometryChange) -> list[RgbdFrame]:
    """Frames with the odometry pose `change(number, pose)`."""
    changed = []
    for number, frame in enumerate(frames):
        assert frame.odometry is not None
        pose = change(number, frame.odometry.T_odom_base)
        odometry = None if pose is None else replace(frame.odometry, T_odom_base=pose)
        changed.append(replace(frame, odometry=odometry))
    return changed


def sources(estimates: list[PoseEstimate]) -> set[str]:
    return {estimate.source for estimate in estimates}


def test_a_drive_is_tracked_better_than_by_odometry() -> None:
    frames = short_drive()
    tracked = follow(frames)
    assert {estimate.state for estimate in tracked} == {TrackingState.TRACKING}
    assert sources(tracked[1:]) == {"odometry"}
    errors = place_errors(tracked, SHORT)
    wheels = frames[-1].odometry.T_odom_base.xy
    true = (true_base(float(SHORT[0])).inverse() @ true_base(float(SHORT[-1]))).xy
    assert errors.max() < 0.02 < np.linalg.norm(wheels - true)
    for estimate, frame in zip(tracked, frames, strict=True):
        again = estimate.T_map_odom @ frame.odometry.T_odom_base
        np.testing.assert_allclose(again.xy, estimate.T_map_base.xy, atol=1e-9)
        assert (np.linalg.eigvalsh(estimate.covariance) > 0).all()


def test_the_map_is_the_odom_frame_of_the_first_frame() -> None:
    first = Tracker(settings=SETTINGS).track(short_drive()[0])
    assert first.T_map_odom is not None
    np.testing.assert_allclose([*first.T_map_odom.xy, first.T_map_odom.yaw], 0, atol=1e-12)


def test_a_common_motion_of_the_odometry_moves_all_poses() -> None:
    """Tracking is equivariant: it does not matter where the odom frame lies."""
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
        Tracker(settings=SETTINGS).track(frame)
    given = Tracker(RigidTransform.identity(), SETTINGS).track(frame)
    np.testing.assert_allclose(given.T_map_camera.as_matrix(), np.eye(4), atol=1e-12)


def test_a_robot_without_odometry_starts_its_map_where_it_stands() -> None:
    frame = replace(short_drive()[0], odometry=None)
    first = Tracker(settings=SETTINGS).track(frame)
    mount = frame.T_base_camera
    assert mount is not None
    np.testing.assert_allclose(first.T_map_camera.as_matrix(), mount.as_matrix(), atol=1e-12)
    assert first.T_map_base is not None
    np.testing.assert_allclose([*first.T_map_base.xy, first.T_map_base.yaw], 0, atol=1e-12)


def steps_and_pillars() -> tuple[Surface, ...]:
    """Objects that determine all six degrees of freedom."""
    places = [(0.45, -0.5), (0.8, 0.4), (-0.1, 0.7), (-0.6, -0.45), (0.1, -0.8), (0.6, 0.9)]
    pillars = [
        Surface(f"pillar {n}", block((x, y, 0.0), (x + 0.12, y + 0.1, 0.2 + 0.1 * n)))
        for n, (x, y) in enumerate(places)
    ]
    return (*SURFACES, *pillars)


def test_a_camera_without_robot_is_tracked_by_constant_velocity() -> None:
    start = true_camera(float(SHORT[0]))
    frames = [
        replace(frame, odometry=None, T_base_camera=None, stamp=0.1 * frame.stamp)
        for frame in drive(SHORT, surfaces=steps_and_pillars())
    ]
    tracked = follow(frames, Tracker(start, SETTINGS))
    assert "constant velocity" in sources(tracked)
    assert {(e.T_map_base, e.T_map_odom) for e in tracked} == {(None, None)}
    assert_reliable_poses_are_right(tracked, SHORT)
    assert tracked[-1].reliable


@pytest.mark.parametrize("start_deg", [200.0, 300.0])
def test_a_camera_without_odometry_may_stop_suddenly(start_deg: float) -> None:
    """From where the last motion would lead, a frame could slide along a flat side."""
    steps = np.concatenate([np.full(5, 2.5), np.full(5, 12.0), np.zeros(3)])
    angles = np.radians(start_deg + np.concatenate([[0.0], np.cumsum(steps)]))
    tracked = follow([replace(frame, odometry=None) for frame in drive(angles)])
    assert_reliable_poses_are_right(tracked, angles)


def test_a_blackout_is_bridged_by_odometry_with_growing_covariance() -> None:
    frames = [blind(f) if 6 <= n < 11 else f for n, f in enumerate(short_drive())]
    tracked = follow(frames)
    sizes = [np.linalg.det(e.covariance[3:, 3:]) for e in tracked[5:11]]
    assert {e.inliers for e in tracked[6:11]} == {0}
    assert [e.unverified for e in tracked] == [not e.reliable for e in tracked]
    assert any(e.unverified for e in tracked)
    assert (np.diff(sizes) > 0).all()
    assert tracked[11].reliable
    assert_reliable_poses_are_right(tracked, SHORT)


def test_spinning_wheels_during_a_blackout_give_no_wrong_pose() -> None:
    """The robot stands, its wheels turn by 3° a frame; then it sees where it is."""
    frames = list(short_drive())
    last, place = frames[-1], frames[-1].odometry
    assert place is not None
    for step in range(1, 11):
        stamp = last.stamp + 0.5 * step
        turned = PlanarPose(place.T_odom_base.x, place.T_odom_base.y,
                            place.T_odom_base.yaw + np.radians(3.0 * step))  # fmt: skip
        odometry = replace(place, stamp=stamp, T_odom_base=turned)
        spinning = replace(last, stamp=stamp, odometry=odometry)
        frames.append(blind(spinning) if step < 9 else spinning)
    angles = np.concatenate([SHORT, np.full(10, SHORT[-1])])
    tracked = follow(frames)
    assert "slipping wheels" in sources(tracked[-2:])
    assert tracked[-1].reliable
    assert_reliable_poses_are_right(tracked, angles)


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_depth_in_the_wrong_unit_is_not_used(factor: float) -> None:
    frames = list(short_drive()[:6])
    frames[3] = replace(frames[3], depth=frames[3].depth * factor)
    tracked = follow(frames)
    assert tracked[3].inliers == 0
    assert tracked[4].reliable
    assert_reliable_poses_are_right(tracked, SHORT[:6])


@pytest.mark.parametrize("kind", ["gone", "stuck", "jumping"])
def test_failed_odometry_gives_no_wrong_pose(kind: str) -> None:
    stuck = short_drive()[5].odometry.T_odom_base
    jump = PlanarPose(0.4, -0.3, 0.5)
    changes: dict[str, OdometryChange] = {
        "gone": lambda n, pose: None if n >= 5 else pose,
        "stuck": lambda n, pose: stuck if n >= 5 else pose,
        "jumping": lambda n, pose: jump @ pose if n >= 8 else pose,
    }
    tracked = follow(with_odometry(list(short_drive()), changes[kind]))
    assert_reliable_poses_are_right(tracked, SHORT)
    assert tracked[-1].reliable


@pytest.mark.parametrize("bounds", [(1e-9, 1.0), (1.0, 1e-9)])
def test_rotation_and_position_must_both_be_known_for_a_reliable_pose(
    bounds: tuple[float, float],
) -> None:
    strict = replace(SETTINGS, max_rotation_sigma=bounds[0], max_translation_sigma=bounds[1])
    tracked = follow(short_drive()[:3], Tracker(settings=strict))[1:]
    assert not any(estimate.reliable for estimate in tracked)
    assert all(estimate.reason.startswith("standard deviations of") for estimate in tracked)


def test_dropped_frames_are_bridged() -> None:
    kept = [0, 1, 2, 4, 5, 8, 9, 12, 15]
    tracked = follow([short_drive()[n] for n in kept])
    assert_reliable_poses_are_right(tracked, SHORT[kept])
    assert all(estimate.reliable for estimate in tracked)


def kidnapped(angle_deg: float, count: int = 8) -> tuple[list[RgbdFrame], np.ndarray]:
    """A drive, then frames from elsewhere; the odometry does not notice."""
    away = np.radians(angle_deg + np.arange(count) * 2.5)
    frames = [*short_drive(), *drive(away)]
    last = frames[15].odometry.T_odom_base
    moved = with_odometry(frames, lambda n, pose: last @ pose if n >= 16 else pose)
    stamped = [replace(frame, stamp=float(n)) for n, frame in enumerate(moved)]
    return stamped, np.concatenate([SHORT, away])


def test_a_kidnapped_robot_in_unknown_space_is_lost() -> None:
    frames, angles = kidnapped(190.0)
    tracked = follow(frames)
    assert not any(estimate.reliable for estimate in tracked[16:])
    assert tracked[-1].lost
    assert tracked[-1].reason
    assert_reliable_poses_are_right(tracked, angles)


def test_a_kidnapped_robot_relocalises_in_known_space() -> None:
    frames, angles = kidnapped(0.0)
    tracked = follow(frames)
    assert "relocalisation" in sources(tracked[16:])
    assert tracked[-1].reliable
    assert_reliable_poses_are_right(tracked, angles)


def almost_blind(frame: RgbdFrame, pixels: int = 24) -> RgbdFrame:
    """Depth in one corner of the image only, as behind a hand or at a window."""
    depth = np.full(frame.depth.shape, np.nan)
    depth[:pixels, :pixels] = frame.depth[:pixels, :pixels]
    return replace(frame, depth=depth)


@pytest.mark.parametrize("hidden", [blind, almost_blind])
def test_empty_frames_do_not_resolve_a_contradiction(
    hidden: Callable[[RgbdFrame], RgbdFrame],
) -> None:
    frames, angles = kidnapped(190.0)
    tracked = follow([*frames[:17], *map(hidden, frames[17:])])
    assert not any(estimate.reliable for estimate in tracked[16:])
    assert_reliable_poses_are_right(tracked, angles)


def test_an_empty_frame_alone_is_bridged() -> None:
    """Nothing has verified the 65 mm that the odometry reports for it."""
    frames = short_drive()
    tracked = follow([*frames[:6], almost_blind(frames[6]), frames[7]])
    assert [estimate.reliable for estimate in tracked[-3:]] == [True, False, True]
    assert tracked[-2].reason.startswith("no scan has verified the last 6")


def test_a_kidnapped_robot_relocalises_though_every_second_frame_is_empty() -> None:
    frames, angles = kidnapped(0.0, count=15)
    away = [blind(f) if n % 2 else f for n, f in enumerate(frames[16:])]
    tracked = follow([*frames[:16], *away])
    assert "relocalisation" in sources(tracked[16:])
    assert tracked[-1].reliable
    assert_reliable_poses_are_right(tracked, angles)


def test_a_loop_is_closed_and_corrected() -> None:
    angles = np.radians(np.arange(45, 430, 5.0))
    tracker = Tracker(settings=SETTINGS)
    tracked = follow(drive(angles), tracker)
    tracker.finalise()
    final = [e.at(T) for e, T in zip(tracked, tracker.corrected(tracked), strict=True)]
    assert tracker.corrections > 0
    corrections = tracker.corrections
    tracker.finalise()
    assert tracker.corrections == corrections  # no frame came since
    assert place_errors(final, angles).max() < NEAR
    # A common frame: the end lies where the beginning lay.
    assert place_errors(final, angles)[-1] < 0.02


def test_pending_work_may_be_done_at_any_time() -> None:
    """At once, or only when the next frame comes; and what was returned does not change."""
    frames, tracker = short_drive(), Tracker(settings=SETTINGS)
    at_once = []
    for frame in frames:
        estimate = tracker.track(frame)
        before = tracker.corrected([estimate])[0].as_matrix()
        tracker.process_pending()
        np.testing.assert_array_equal(tracker.corrected([estimate])[0].as_matrix(), before)
        at_once.append(estimate)
    assert len(tracker.keyframes) > 1
    for one, other in zip(at_once, follow(frames), strict=True):
        np.testing.assert_array_equal(one.T_map_camera.as_matrix(), other.T_map_camera.as_matrix())
        np.testing.assert_array_equal(one.covariance, other.covariance)


def test_keyframes_stay_few_and_frames_at_culled_ones_stay_placed() -> None:
    keyframes = KeyframeSettings(max_baseline=0.02, max_rotation=0.05, max_keyframes=5)
    tracker = Tracker(settings=replace(SETTINGS, keyframes=keyframes))
    tracked = follow(short_drive(), tracker)
    tracker.finalise()
    assert len(tracker.keyframes) == 5
    final = [e.at(T) for e, T in zip(tracked, tracker.corrected(tracked), strict=True)]
    assert place_errors(final, SHORT).max() < NEAR


def after_a_blind_passage(end_deg: float, off: float) -> tuple[list[PoseEstimate], np.ndarray]:
    """The drive continues blindly to an azimuth, where the odometry is off by so much [m]."""
    angles = np.concatenate([SHORT, np.radians(np.arange(60.0, end_deg + 1, 2.5))])
    frames = drive(angles)
    odometry, variance = frames[-1].odometry, np.diag([2 * off, 2 * off, off / 5]) ** 2
    there = replace(odometry.T_odom_base, x=odometry.T_odom_base.x + off)
    moved = replace(odometry, T_odom_base=there, covariance=odometry.covariance + variance)
    frames[-1] = replace(frames[-1], odometry=moved)
    dark = map(blind, frames[len(SHORT) : -1])
    return follow([*frames[: len(SHORT)], *dark, frames[-1]]), angles


@pytest.mark.parametrize(("end_deg", "off"), [(100.0, 0.0), (180.0, 0.1)])
def test_unexplored_space_does_not_confirm_an_uncertain_pose(end_deg: float, off: float) -> None:
    tracked, angles = after_a_blind_passage(end_deg, off)
    assert_reliable_poses_are_right(tracked, angles)
    assert off == 0 or not tracked[-1].reliable


def test_after_two_blind_frames_without_odometry_a_new_view_is_not_reliable() -> None:
    angles = np.concatenate([SHORT, np.radians([60.0, 62.5, 120.0])])
    frames = drive(angles)
    without_odometry = with_odometry(frames[16:], lambda *_: None)
    tracked = follow(
        [*frames[:16], blind(without_odometry[0]), blind(without_odometry[1]), without_odometry[2]]
    )
    assert_reliable_poses_are_right(tracked, angles)
    assert not tracked[-1].reliable


@pytest.mark.parametrize("turn_deg", [90.0, 180.0])
def test_an_ambiguous_camera_keeps_several_hypotheses(turn_deg: float) -> None:
    """Without odometry, after a blackout, at a pillar whose four sides look the same."""
    mapped, blackout = np.arange(0, 395, 5.0), np.linspace(395, 395 + turn_deg, 12)
    after = blackout[-1] + np.arange(5.0, 30, 5.0)
    angles = np.radians(np.concatenate([mapped, blackout, after]))
    frames = drive(angles, surfaces=SQUARE)
    without_odometry = with_odometry(frames[len(mapped) :], lambda *_: None)
    dark = [blind(frame) for frame in without_odometry[: len(blackout)]]
    tracked = follow([*frames[: len(mapped)], *dark, *without_odometry[len(blackout) :]])
    assert_reliable_poses_are_right(tracked, angles)
    assert not any(estimate.reliable for estimate in tracked[len(mapped) + 1 :])
    assert max(estimate.hypotheses for estimate in tracked[-5:]) > 1


def test_odometry_that_jumps_twice_gives_no_wrong_pose() -> None:
    jumps = {14: PlanarPose(0.0, 0.12, 0.0), 15: PlanarPose(0.0, 0.16, 0.0)}
    frames = with_odometry(list(short_drive()), lambda n, pose: pose @ jumps.get(n, PlanarPose()))
    tracked = follow(frames)
    assert_reliable_poses_are_right(tracked, SHORT)
    assert tracked[14].source != "odometry"


@pytest.mark.parametrize("step_deg", [5.0, 12.5])
def test_loops_are_closed_while_a_robot_drives_fast(step_deg: float) -> None:
    """13 cm or 33 cm a frame."""
    keyframes = KeyframeSettings(min_correction=0.0, min_correction_rotation=0.0)
    tracker = Tracker(settings=replace(SETTINGS, keyframes=keyframes))
    follow(drive(np.radians(np.arange(45, 45 + 360 + 35, step_deg))), tracker)
    assert tracker.corrections > 0


def test_an_interrupted_finalisation_may_be_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    tracker = Tracker(settings=SETTINGS)
    follow(short_drive(), tracker)

    def interrupted() -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(tracker.keyframes, "optimise", lambda **_: interrupted())
        with pytest.raises(KeyboardInterrupt):
            tracker.finalise()
    before = tracker.corrections
    tracker.finalise()
    assert tracker.corrections == before + 1
