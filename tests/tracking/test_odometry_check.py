"""Odometry on another clock, or wrong, noticed by the motions that registration finds."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import short_drive

from circumspect.geometry import PlanarPose
from circumspect.robot import arc
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.tracking import OdometryCheck, PoseEstimate, TrackingState
from circumspect.tracking.odometry_check import contradicting_motions, odometry_lag

TICK = 0.1
NOISE = (0.002, 0.002, 0.002)
"""Of registered poses [m], [rad]."""


@lru_cache(maxsize=8)
def drive(seed: int, seconds: float = 30.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, true poses and odometry with 5 % of slip: the robot turns and drives by turns."""
    rng, count = np.random.default_rng(seed), round(seconds / TICK)
    speed = spin = 0.0
    true, reported = [PlanarPose()], [PlanarPose()]
    for tick in range(count):
        if tick % 15 == 0:
            wanted = [(0.05, 0.0), (0.0, 0.2), (0.05, -0.1), (0.0, -0.2)][tick // 15 % 4]
        speed += np.clip(wanted[0] - speed, -0.3 * TICK, 0.3 * TICK)
        spin += np.clip(wanted[1] - spin, -TICK, TICK)
        slip = 1 + 0.05 * rng.exponential()
        true.append(true[-1] @ arc(speed * TICK, spin * TICK))
        reported.append(reported[-1] @ arc(slip * speed * TICK, slip * spin * TICK))
    return TICK * np.arange(count + 1), as_array(true), as_array(reported)


def as_array(poses: list[PlanarPose]) -> np.ndarray:
    rows = np.array([(pose.x, pose.y, pose.yaw) for pose in poses])
    return np.column_stack([rows[:, :2], np.unwrap(rows[:, 2])])


def registered_drive(
    interval: float, lag: float, count: int, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps, registered poses and odometry of so many frames."""
    times, true, reported = drive(seed)
    stamps = 2.0 + interval * np.arange(count)
    registered = at(stamps, times, true)
    registered += np.random.default_rng(seed).normal(size=registered.shape) * NOISE
    return stamps, registered, at(stamps - lag, times, reported)


def at(when: np.ndarray, times: np.ndarray, poses: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(when, times, column) for column in poses.T])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lag", [-1.0, -0.5, 0.5, 1.0])
def test_another_clock_is_noticed_within_20_frames(lag: float, seed: int) -> None:
    found = odometry_lag(*registered_drive(0.5, lag, 20, seed))
    assert found == pytest.approx(lag, abs=0.21)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lag", [-0.2, 0.0, 0.1, 0.2])
@pytest.mark.parametrize("interval", [0.2, 0.5, 1.0])
def test_usual_latency_is_no_other_clock(interval: float, lag: float, seed: int) -> None:
    for count in range(2, round(26 / interval), 3):
        assert odometry_lag(*registered_drive(interval, lag, count, seed)) is None


def with_fault(fault: str, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """40 frames, as `registered_drive`, with a fault from frame 15 or 20 on; slip from the start."""
    stamps, registered, odometry = registered_drive(0.5, 0.0, 40, seed)
    if fault == "jump":
        odometry[20:] += (0.3, -0.2, 0.4)
    elif fault == "stuck":
        odometry[15:] = odometry[15]
    elif fault == "blocked":
        registered[15:] = registered[15]
    elif fault == "slip":
        odometry *= 1.25
    elif fault == "kidnapped":
        registered[20:] += (0.3, -0.1, 0.35)
    return stamps, registered, odometry


@pytest.mark.parametrize("fault", ["jump", "stuck", "blocked", "slip", "kidnapped"])
def test_other_faults_are_no_other_clock(fault: str) -> None:
    for seed in range(4):
        stamps, registered, odometry = with_fault(fault, seed)
        for count in range(2, 41):
            assert odometry_lag(stamps[:count], registered[:count], odometry[:count]) is None


def test_errors_that_usual_noise_explains_are_no_other_clock(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Slip is correlated in time: a lag may fit small errors better by chance."""
    stamps = 0.5 * np.arange(40)

    def driven(times: np.ndarray) -> np.ndarray:
        yaw = 0.02 * np.cos(2 * np.pi * times / 10)
        return np.column_stack([0.05 * times, 0 * times, np.cumsum(yaw)])

    registered, odometry = driven(stamps), driven(stamps - 1.0)
    assert odometry_lag(stamps, registered, odometry) is None
    # The comparison of lags alone would take it for another clock.
    monkeypatch.setattr("circumspect.tracking.odometry_check.EXPECTED_COST", 0.1)
    assert odometry_lag(stamps, registered, odometry) is not None


def test_wheels_that_slip_unequally_are_no_other_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """While the robot turns less and less, a lag would explain that it turns too little."""
    stamps = np.arange(20.0)

    def driven(turning: np.ndarray, step_m: float) -> np.ndarray:
        poses = [PlanarPose()]
        for turn in turning[1:]:
            poses.append(poses[-1] @ arc(step_m, turn))
        return as_array(poses)

    turning = np.radians(np.linspace(-3.5, 3.5, 20))
    registered = driven(turning - np.radians(0.7), 0.05)
    motions = stamps, registered, driven(turning, 0.05)
    assert odometry_lag(*motions) is None
    monkeypatch.setattr("circumspect.tracking.odometry_check.TURN_VARIANCE", 0.0)
    assert odometry_lag(*motions) is not None


def test_a_uniform_motion_is_no_evidence() -> None:
    stamps = 0.5 * np.arange(30)
    poses = as_array([arc(0.05 * stamp, 0.1 * stamp) for stamp in stamps])
    lagging = as_array([arc(0.05 * (stamp - 1), 0.1 * (stamp - 1)) for stamp in stamps])
    assert odometry_lag(stamps, poses, lagging) is None


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("fault", ["stuck", "blocked"])
def test_most_motions_contradict_odometry_that_is_wrong(fault: str, seed: int) -> None:
    # The first 15 frames are correct.
    contradicting = contradicting_motions(*(a[15:] for a in with_fault(fault, seed)))
    assert len(contradicting) >= 20
    assert contradicting.mean() > 0.5


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("fault", ["none", "jump", "kidnapped"])
def test_few_motions_contradict_odometry_that_jumps(fault: str, seed: int) -> None:
    contradicting = contradicting_motions(*with_fault(fault, seed))
    assert contradicting.sum() <= (fault != "none")


def test_odometry_is_excluded_while_it_is_wrong(caplog: pytest.LogCaptureFixture) -> None:
    stamps, registered, odometry = registered_drive(0.5, 0.0, 58, 0)
    wrong = odometry.copy()
    wrong[:20] = wrong[20]
    check, used = OdometryCheck(), []
    for frame, pose in as_frames(stamps, registered, wrong):
        used.append(check.filter(frame).odometry is not None)
        check.update(frame, pose)
    first = used.index(False)
    assert first <= 12
    again = used.index(True, 20)
    assert again <= 27
    assert not any(used[first:again])
    assert all(used[again:])
    assert caplog.text.count("odometry contradicts the motion of the images") == 1


@pytest.mark.parametrize("silence", ["standing still", "creeping", "dead reckoning"])
def test_stuck_odometry_stays_excluded_without_evidence_for_it(silence: str) -> None:
    """Stuck odometry fits a robot that stands still; a slow one contradicts no frame of it."""
    stamps, registered, odometry = registered_drive(0.5, 0.0, 50, 0)
    odometry[:] = odometry[0]
    check, pairs = OdometryCheck(), as_frames(stamps[:20], registered[:20], odometry[:20])
    for frame, pose in pairs:
        check.update(frame, pose)
    assert check.filter(pairs[-1][0]).odometry is None
    rest = 20 + np.arange(60)
    still = np.repeat(registered[19:20], 60, axis=0)
    if silence == "creeping":
        still[:, 0] += 0.012 * np.arange(1, 61)
    quiet = as_frames(2.0 + 0.5 * rest, still, np.repeat(odometry[:1], 60, axis=0))
    for frame, pose in quiet:
        if silence == "dead reckoning":
            pose = replace(pose, state=TrackingState.DEAD_RECKONING)
        check.update(frame, pose)
        assert check.filter(frame).odometry is None


def frames(lag: float, count: int = 30) -> list[tuple[RgbdFrame, PoseEstimate]]:
    """Frames with odometry that lags, and their registered poses."""
    return as_frames(*registered_drive(0.5, lag, count, 0))


def as_frames(
    stamps: np.ndarray, registered: np.ndarray, odometry: np.ndarray
) -> list[tuple[RgbdFrame, PoseEstimate]]:
    some, pairs = short_drive()[0], []
    for stamp, pose, reported in zip(stamps, registered, odometry, strict=True):
        base = PlanarPose(*pose)
        frame = replace(
            some, stamp=float(stamp), odometry=Odometry(float(stamp), PlanarPose(*reported))
        )
        pairs.append((frame, PoseEstimate(RigidTransform.identity(), T_map_base=base)))
    return pairs


def test_odometry_of_another_clock_is_removed_and_reported_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    check = OdometryCheck()
    kept = []
    for frame, pose in frames(lag=1.0):
        checked = check.filter(frame)
        check.update(frame, pose)
        kept.append(checked.odometry is not None)
    first = kept.index(False)
    assert 5 <= first <= 20
    assert not any(kept[first:])
    assert check.warning.startswith("odometry and images are on different clocks: odometry lags")
    assert caplog.text.count("different clocks") == 1


def test_odometry_of_the_same_clock_is_kept() -> None:
    check = OdometryCheck()
    for frame, pose in frames(lag=0.0):
        assert check.filter(frame) is frame
        check.update(frame, pose)
    assert not check.warning


def test_poses_that_are_not_reliable_are_no_evidence() -> None:
    check = OdometryCheck()
    for frame, pose in frames(lag=1.0):
        check.filter(frame)
        check.update(frame, replace(pose, state=TrackingState.DEAD_RECKONING))
    assert not check.warning


@pytest.mark.parametrize("ahead", [-1.7e9, 1.7e9, 3.0])
def test_odometry_of_another_epoch_is_removed_at_once(
    ahead: float, caplog: pytest.LogCaptureFixture
) -> None:
    check = OdometryCheck()
    for frame, _ in frames(lag=0.0, count=3):
        assert frame.odometry is not None
        reported = replace(frame.odometry, stamp=frame.stamp + ahead)
        assert check.filter(replace(frame, odometry=reported)).odometry is None
    assert check.warning.endswith(f"their stamps differ by {abs(ahead):.1f} s")
    assert caplog.text.count("different clocks") == 1
    frame = frames(lag=0.0, count=1)[0][0]
    assert check.filter(frame).odometry is not None
    assert not check.warning
