from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from robot_world import ROUND, odometry_pose, robot, true_pose

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.robot import MobileRobot, Velocity, WrappedRobot
from circumspect.sensing import RgbdFrame
from circumspect.simulation import (
    Blackout,
    Blocked,
    ClockStartingAt,
    DroppedFrames,
    EqualStamps,
    Kidnapped,
    NanFrame,
    OdometryCovariance,
    OdometryGone,
    OdometryJumping,
    OdometryLagging,
    OdometryOfAnotherEpoch,
    OdometryStuck,
    SimulatedRobot,
    UnorderedFrames,
    WrongUnit,
)


def drive_on(driver: MobileRobot, count: int = 20) -> list[RgbdFrame]:
    driver.drive(ROUND)
    frames = []
    for _ in range(count):
        driver.wait(0.5)
        frames.append(driver.observe())
    return frames


def stamps(frames: list[RgbdFrame]) -> np.ndarray:
    return np.array([frame.stamp for frame in frames])


def poses(frames: list[RgbdFrame]) -> list[PlanarPose]:
    assert all(frame.odometry for frame in frames)
    return [frame.odometry.T_odom_base for frame in frames if frame.odometry]


MAKERS: dict[str, Callable[[SimulatedRobot, int], MobileRobot]] = {
    "blackout": lambda r, s: Blackout(r, 2.0, 5.0),
    "dropped": lambda r, s: DroppedFrames(r, 0.3, s),
    "unordered": lambda r, s: UnorderedFrames(r, 0.3, s),
    "equal": lambda r, s: EqualStamps(r, 0.3, s),
    "nan": lambda r, s: NanFrame(r, 3),
    "unit": lambda r, s: WrongUnit(r, 3.0),
    "gone": lambda r, s: OdometryGone(r, 3.0),
    "jumping": lambda r, s: OdometryJumping(r, 3.0, seed=s),
    "stuck": lambda r, s: OdometryStuck(r, 3.0),
    "covariance": lambda r, s: OdometryCovariance(r, 0.1),
    "clock": lambda r, s: ClockStartingAt(r, 0.0),
    "epoch": lambda r, s: OdometryOfAnotherEpoch(r),
    "lag": lambda r, s: OdometryLagging(r, 0.5),
    "blocked": lambda r, s: Blocked(r, 3.0),
    "kidnapped": lambda r, s: Kidnapped(r, 3.0, PlanarPose(0.2, 0.3, 1.0)),
}


@pytest.mark.parametrize("name", MAKERS)
def test_a_fault_is_the_same_for_the_same_seed(name: str) -> None:
    one, same = (drive_on(MAKERS[name](robot(), 5), 8) for _ in range(2))
    for a, b in zip(one, same, strict=True):
        np.testing.assert_array_equal(a.depth, b.depth)
        assert a.stamp == b.stamp
        assert (a.odometry is None) == (b.odometry is None)
        if a.odometry and b.odometry:
            assert a.odometry.T_odom_base == b.odometry.T_odom_base


@pytest.mark.parametrize("name", MAKERS)
def test_a_faulty_robot_is_unchanged_before_the_fault(name: str) -> None:
    healthy = robot()
    faulty = MAKERS[name](robot(), 5)
    for wrapped, plain in zip(
        (faulty.radius, faulty.now, faulty.max_forward, faulty.max_turn),
        (healthy.radius, healthy.now, healthy.max_forward, healthy.max_turn),
        strict=True,
    ):
        assert wrapped == plain
    np.testing.assert_array_equal(
        faulty.T_base_camera.as_matrix(), healthy.T_base_camera.as_matrix()
    )
    healthy.drive(ROUND)
    faulty.drive(ROUND)
    healthy.wait(1.0)
    faulty.wait(1.0)
    assert odometry_pose(faulty) == odometry_pose(healthy)
    faulty.stop()
    faulty.wait(0.5)
    assert faulty.camera.capture().stamp == pytest.approx(1.5)


def test_a_blackout_lasts_five_seconds() -> None:
    frames = drive_on(Blackout(robot(), after=2.0))
    dark = np.array([not frame.valid.any() for frame in frames])
    np.testing.assert_array_equal(dark, (stamps(frames) >= 2) & (stamps(frames) < 7))


def test_dropped_frames_leave_gaps_while_the_robot_drives_on() -> None:
    frames = drive_on(DroppedFrames(robot(), 0.3, seed=1), 60)
    steps = np.diff(stamps(frames))
    np.testing.assert_allclose(np.remainder(steps + 0.25, 0.5), 0.25, atol=1e-6)
    lost = (steps / 0.5 - 1).sum()
    assert lost / (lost + len(steps)) == pytest.approx(0.3, abs=0.12)
    assert frames[-1].odometry is not None


def test_unordered_frames_come_once_each_and_some_late() -> None:
    times = stamps(drive_on(UnorderedFrames(robot(), 0.3, seed=1), 30))
    assert (np.diff(times) < 0).any()
    assert len(set(times.round(3))) == len(times)


def test_a_late_frame_keeps_the_odometry_of_its_own_time() -> None:
    for frame in drive_on(UnorderedFrames(robot(), 0.5, seed=1), 12):
        assert frame.odometry is not None
        assert frame.odometry.stamp == frame.stamp


def test_equal_stamps_occur() -> None:
    steps = np.diff(stamps(drive_on(EqualStamps(robot(), 0.4, seed=2))))
    assert (steps == 0).any()
    assert (steps >= 0).all()


def test_one_frame_is_nan() -> None:
    frames = drive_on(NanFrame(robot(), 3), 8)
    assert [not frame.valid.any() for frame in frames] == [i == 3 for i in range(8)]


def test_the_depth_unit_changes_during_the_run() -> None:
    frames = drive_on(WrongUnit(robot(), after=2.0), 8)
    medians = np.array([np.nanmedian(frame.depth) for frame in frames])
    assert (medians[stamps(frames) >= 2] > 300).all()
    assert (medians[stamps(frames) < 2] < 10).all()


def test_odometry_is_missing_for_a_while() -> None:
    driver = OdometryGone(robot(), after=2.0, seconds=3.0)
    frames = drive_on(driver)
    gone = [frame.odometry is None for frame in frames]
    np.testing.assert_array_equal(gone, (stamps(frames) >= 2) & (stamps(frames) < 5))
    assert driver.odometry() is not None


def test_odometry_jumps_at_intervals() -> None:
    driver = robot()
    frames = drive_on(OdometryJumping(driver, after=2.2, every=3.0, metres=0.4, seed=3))
    healthy = poses(drive_on(robot()))
    away = [
        (measured @ true.inverse()) for measured, true in zip(poses(frames), healthy, strict=True)
    ]
    offsets = np.array([[a.x, a.y, a.yaw] for a in away])
    jumps = np.abs(np.diff(offsets, axis=0)).max(axis=1) > 1e-6
    np.testing.assert_allclose(stamps(frames)[1:][jumps], [2.5, 5.5, 8.5])
    assert np.abs(offsets[0]).max() < 1e-9


def test_odometry_is_stuck_while_the_robot_drives() -> None:
    driver = robot()
    frames = drive_on(OdometryStuck(driver, after=3.0))
    measured = poses(frames)
    late = [pose for pose, t in zip(measured, stamps(frames), strict=True) if t >= 3.0]
    assert len(set(late)) == 1
    assert late[0].xy == pytest.approx(measured[4].xy, abs=1e-9)
    assert frames[-1].odometry is not None
    assert frames[-1].odometry.forward == 0
    assert frames[-1].odometry.stamp == frames[-1].stamp
    assert np.hypot(*(true_pose(driver).xy - true_pose(robot()).xy)) > 0.5


def test_a_blocked_robot_stands_while_its_odometry_moves() -> None:
    inner = robot()
    driver = Blocked(inner, after=2.0, seconds=4.0)
    driver.drive(ROUND)
    driver.wait(3.0)
    before, measured_before = true_pose(inner), odometry_pose(driver)
    driver.wait(2.9)
    assert np.hypot(*(true_pose(inner).xy - before.xy)) < 1e-3
    moved = measured_before.inverse() @ odometry_pose(driver)
    assert moved.yaw == pytest.approx(ROUND.turn * 2.9, abs=0.01)
    assert np.hypot(*moved.xy) == pytest.approx(0.87, abs=0.03)
    odometry = driver.odometry()
    assert odometry is not None
    assert odometry.forward == pytest.approx(ROUND.forward)
    driver.wait(3.0)
    assert np.hypot(*(true_pose(inner).xy - before.xy)) > 0.5


def test_a_blocked_robot_reports_the_covariance_of_a_free_one() -> None:
    driver, free = Blocked(robot(), after=2.0, seconds=4.0), robot()
    measured = [[frame.odometry for frame in drive_on(each)] for each in (driver, free)]
    for before, now in zip(measured[0], measured[0][1:], strict=False):
        grown = np.linalg.eigvalsh(now.growth_since(before))
        assert grown[0] > -1e-12
    blocked, drove = (np.sqrt(np.diag(each[-1].covariance)) for each in measured)
    # The wheels drew no noise while the robot stood.
    assert (blocked < 1.05 * drove).all()
    assert (blocked > 0.3 * drove).all()


def test_a_kidnapped_robot_is_elsewhere_while_its_odometry_stands() -> None:
    inner, healthy = robot(), robot()
    by = PlanarPose(0.3, -0.4, 0.8)
    driver = Kidnapped(inner, 2.0, by)
    for each in (driver, healthy):
        each.wait(4.0)
    there = true_pose(healthy).inverse() @ true_pose(inner)
    np.testing.assert_allclose([there.x, there.y, there.yaw], [by.x, by.y, by.yaw], atol=5e-3)
    np.testing.assert_allclose(odometry_pose(driver).xy, 0, atol=2e-3)


def test_faults_can_be_combined() -> None:
    frames = drive_on(OdometryGone(Blackout(robot(), 2.0, 1.0), 2.0, 1.0), 8)
    for frame in frames:
        within = 2.0 <= frame.stamp < 3.0
        assert (frame.odometry is None) == within
        assert (not frame.valid.any()) == within


def test_a_wrapped_robot_without_fault_is_unchanged() -> None:
    one, other = drive_on(WrappedRobot(robot()), 3), drive_on(robot(), 3)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.depth, b.depth)


def test_commands_beyond_the_limits_are_clipped_while_blocked() -> None:
    driver = Blocked(robot(), after=0.0, seconds=10.0)
    driver.drive(Velocity(50.0))
    driver.wait(1.0)
    assert odometry_pose(driver).x == pytest.approx(driver.max_forward, rel=0.05)


@pytest.mark.parametrize("share", [-0.1, 1.0, np.nan])
@pytest.mark.parametrize("fault", [DroppedFrames, UnorderedFrames, EqualStamps])
def test_impossible_shares_are_refused(
    fault: Callable[[MobileRobot, float], MobileRobot], share: float
) -> None:
    with pytest.raises(InputError, match="fraction"):
        fault(robot(), share)


def test_a_clock_starts_at_the_given_time() -> None:
    plain, shifted = drive_on(robot(), 3), drive_on(ClockStartingAt(robot(), 1000.0), 3)
    np.testing.assert_allclose(stamps(shifted) - stamps(plain), 1000.0)
    for frame in shifted:
        assert frame.odometry is not None
        assert frame.odometry.stamp == pytest.approx(frame.stamp)
    assert ClockStartingAt(robot(), 1000.0).now == 1000.0


def test_odometry_of_another_epoch_differs_in_its_stamps_alone() -> None:
    plain, shifted = drive_on(robot(), 3), drive_on(OdometryOfAnotherEpoch(robot(), 50.0), 3)
    np.testing.assert_array_equal(stamps(shifted), stamps(plain))
    assert poses(shifted) == poses(plain)
    assert [f.odometry.stamp - f.stamp for f in shifted if f.odometry] == pytest.approx([50.0] * 3)


def test_lagging_odometry_is_that_of_earlier_frames() -> None:
    plain, lagging = drive_on(robot(), 8), drive_on(OdometryLagging(robot(), 1.0), 8)
    assert lagging[0].odometry is None
    assert poses(lagging[2:]) == poses(plain[:-2])
    for frame in lagging[2:]:
        assert frame.odometry is not None
        assert frame.odometry.stamp == frame.stamp


@pytest.mark.parametrize(("variance", "kept"), [(0.1, 0.1), (np.nan, 0.0)])
def test_a_constant_covariance_is_that_of_all_frames(variance: float, kept: float) -> None:
    for frame in drive_on(OdometryCovariance(robot(), variance), 3):
        assert frame.odometry is not None
        np.testing.assert_array_equal(frame.odometry.covariance, np.eye(3) * kept)
