"""Tracking with sightings that are late, contradictory or missing."""

from __future__ import annotations

import numpy as np
import pytest
from ceiling_world import sighted, unlike
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.localization import (
    BRIDGED,
    LOST,
    TRACKED,
    MotionFilter,
    Sighting,
    SpaceSettings,
    SpaceTrack,
    SpaceTracker,
)

SPEED = 0.2


def driven(tracker, seconds, *cameras, start=0.0, step=0.1):
    """Cameras (name, offset along x [m]) see a robot that drives along x."""
    fixes = []
    for n in range(round(seconds / step)):
        t = start + n * step
        fixes.append(
            tracker.take(t, [sighted(name, t, SPEED * t + off, 0.0) for name, off in cameras])
        )
    return fixes


def test_agreeing_cameras_are_fused_and_a_pose_follows():
    fixes = driven(SpaceTracker(), 2.0, ("a", 0.0), ("b", 0.001))
    assert {fix.state for fix in fixes} == {TRACKED}
    assert fixes[-1].cameras == ("a", "b")
    assert fixes[-1].T_map_base.x == pytest.approx(SPEED * 1.9 + 0.0005, abs=1e-3)
    assert fixes[-1].note is None


def test_drop_outs_are_bridged_with_growing_covariance_until_lost():
    tracker = SpaceTracker(SpaceSettings(lost_after=1.0))
    driven(tracker, 2.0, ("a", 0.0))
    gone = driven(tracker, 2.0, start=2.0)
    states = [fix.state for fix in gone]
    assert states[0] == BRIDGED
    assert states[-1] == LOST
    assert states == sorted(states)
    bridged = [fix for fix in gone if fix.state == BRIDGED]
    assert len(bridged) == pytest.approx(9, abs=1)
    assert (np.diff([fix.position_sigma for fix in bridged]) > 0).all()
    for fix in bridged:
        off = unlike(fix.T_map_base, PlanarPose(SPEED * fix.stamp, 0, 0))
        assert off @ np.linalg.solve(fix.covariance, off) < 12
    assert gone[-1].T_map_base is None
    assert np.isnan(gone[-1].position_sigma)
    assert gone[-1].note == "no camera sees the tag"
    assert driven(tracker, 0.2, ("a", 0.0), start=4.0)[-1].state == TRACKED


def test_without_sightings_the_state_is_lost():
    assert SpaceTracker().take(0.0, []).state == LOST


def test_of_three_cameras_the_outlier_is_excluded_and_reported():
    tracker = SpaceTracker()
    fixes = driven(tracker, 2.0, ("a", 0.0), ("b", 0.03), ("c", 0.001))
    assert all(fix.cameras == ("a", "c") for fix in fixes)
    assert fixes[0].sightings[1].reason == "contradicts the other cameras"
    assert fixes[-1].sightings[1].reason == "moved since calibration"
    (report,) = tracker.watch.reports
    assert report.startswith("camera 'b' moved since calibration: it differs by 30 mm")
    # Alone it is no longer used, and no wrong pose goes unreported.
    alone = driven(tracker, 4.0, ("b", 0.03), start=2.0)
    assert {fix.state for fix in alone} == {BRIDGED, LOST}
    assert "moved since calibration" in alone[-1].note
    # Calibrated again, it agrees, and is used.
    after = driven(tracker, 3.0, ("a", 0.0), ("b", 0.0), ("c", 0.0), start=6.0)
    assert after[-1].cameras == ("a", "b", "c")
    assert tracker.watch.reports == ()


def test_two_cameras_that_disagree_from_the_start_are_both_rejected():
    tracker = SpaceTracker()
    fixes = driven(tracker, 2.0, ("a", 0.0), ("b", 0.04))
    assert {fix.state for fix in fixes} == {LOST}
    assert "a and b are 40 mm apart and nothing decides" in fixes[0].note
    (report,) = tracker.watch.reports
    assert "one of the cameras 'a' or 'b' moved since calibration" in report
    # One of them alone is used, but always with a note.
    alone = driven(tracker, 0.5, ("b", 0.04), start=2.0)
    assert all(fix.note and "in dispute" in fix.note for fix in alone)


def test_a_disagreement_of_two_cameras_is_decided_by_the_motion_and_reported():
    tracker = SpaceTracker()
    driven(tracker, 1.0, ("a", 0.0))
    fixes = driven(tracker, 2.0, ("a", 0.0), ("b", 0.08), start=1.0)
    assert all(fix.cameras == ("a",) and "80 mm apart" in fix.note for fix in fixes)
    assert "'a' or 'b'" in tracker.watch.reports[0]


def test_a_single_outlier_is_bridged():
    tracker = SpaceTracker()
    driven(tracker, 1.0, ("a", 0.0))
    fix = tracker.take(1.0, [sighted("a", 1.0, 5.0, 0.0)])
    assert fix.state == BRIDGED
    assert fix.sightings[0].reason == "a contradicts the predicted motion"
    assert fix.T_map_base.x == pytest.approx(SPEED, abs=0.02)
    assert tracker.take(1.1, [sighted("a", 1.1, SPEED * 1.1, 0.0)]).state == TRACKED


def test_a_kidnapped_robot_is_tracked_where_cameras_agree():
    tracker = SpaceTracker()
    driven(tracker, 1.0, ("a", 0.0), ("b", 0.0))
    fix = tracker.take(1.0, [sighted("a", 1.0, 3.0, 1.0), sighted("b", 1.0, 3.0, 1.0)])
    assert fix.state == TRACKED
    assert "carried away" in fix.note
    assert fix.T_map_base.x == pytest.approx(3.0, abs=1e-3)


def test_hand_over_from_one_camera_to_the_next_is_smooth():
    tracker = SpaceTracker()
    fixes = driven(tracker, 1.0, ("a", 0.0))
    fixes += driven(tracker, 0.5, ("a", 0.0), ("b", 0.0015), start=1.0)
    fixes += driven(tracker, 1.0, ("b", 0.0015), start=1.5)
    assert {fix.state for fix in fixes} == {TRACKED}
    steps = np.diff([fix.T_map_base.x for fix in fixes])
    assert np.abs(steps - 0.1 * SPEED).max() < 2.5e-3


@given(st.permutations(["a", "b", "c", "d"]))
def test_the_order_of_cameras_does_not_matter(order):
    def run(names):
        tracker = SpaceTracker()
        offsets = {"a": 0.0, "b": 0.001, "c": 0.05, "d": -0.001}
        return driven(tracker, 0.5, *((name, offsets[name]) for name in names))

    for one, other in zip(run("abcd"), run(order), strict=True):
        np.testing.assert_allclose(unlike(one.T_map_base, other.T_map_base), 0, atol=1e-12)
        assert set(one.cameras) == set(other.cameras)


def test_sightings_of_nearly_one_time_are_propagated_to_it():
    tracker = SpaceTracker()
    driven(tracker, 2.0, ("a", 0.0))
    late = sighted("b", 2.02, SPEED * 2.02, 0.0)
    fix = tracker.take(2.0, [sighted("a", 2.0, SPEED * 2.0, 0.0), late])
    assert fix.cameras == ("a", "b")
    assert fix.sightings[1].pose.T_map_base.x == pytest.approx(SPEED * 2.0, abs=1e-3)


def test_many_measurements_do_not_average_the_bias_away():
    accurate = sighted("a", 0.0, 0.0, 0.0)
    tracker = SpaceTracker()
    for n in range(200):
        fix = tracker.take(0.1 * n, [Sighting("a", 0.1 * n, accurate.pose)])
    assert fix.covariance[0, 0] > accurate.pose.bias[0, 0]


def test_the_filter_does_not_go_back_in_time():
    motion = MotionFilter(1.0, PlanarPose(0, 0, 3.1), 1e-6 * np.eye(3), 0.3, 1.0)
    with pytest.raises(InputError, match="forward"):
        motion.advance(0.5)
    for n in range(1, 20):
        motion.advance(1.0 + 0.1 * n)
        motion.update(PlanarPose(0.02 * n, 0, 3.1 + 0.01 * n), 1e-6 * np.eye(3))
    np.testing.assert_allclose(motion.rates, [0.2, 0, 0.1], atol=5e-3)
    assert motion.pose.yaw == pytest.approx(3.1 + 0.19 - 2 * np.pi, abs=1e-3)
    assert np.linalg.eigvalsh(motion.covariance).min() > 0


def test_a_track_has_a_summary():
    tracker = SpaceTracker()
    fixes = driven(tracker, 1.0, ("a", 0.0)) + driven(tracker, 0.5, start=1.0)
    track = SpaceTrack.of([*fixes, fixes[0]], tracker.watch.reports)
    summary = track.summary()
    assert summary["times"] == 15
    assert summary["states"] == {TRACKED: 10, BRIDGED: 5}
    assert summary["cameras"] == {"a": 10}
    assert 0.5e-3 < summary["space_error_m"] < 2e-3
    assert len(track.trajectory()) == 15
    assert len(track.trajectory(bridged=False)) == 10
    assert SpaceTrack(()).trajectory() is None
    assert SpaceTrack(()).stated_error_m is None


@pytest.mark.parametrize(
    "what",
    [
        {"corner_sigma": 0},
        {"max_squared_distance": -1},
        {"workers": 0},
        {"min_contradictions": 30},
        {"slot": 9},
    ],
)
def test_invalid_settings_are_refused(what):
    with pytest.raises(InputError):
        SpaceSettings(**what)
