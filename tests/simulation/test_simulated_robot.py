from __future__ import annotations

import gc
import sys
import time
import weakref

import numpy as np
import pytest
from robot_world import BOX, CAMERA, EMPTY, ON_CIRCLE, ROUND, odometry_pose, robot, true_pose
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry import PlanarPose
from circumspect.robot import Velocity
from circumspect.sensing import DepthNoise
from circumspect.simulation import (
    CameraMount,
    RobotSettings,
    Scene,
    SimulatedRobot,
    Surface,
    block,
    floor,
)
from circumspect.simulation.orbit import MIN_MAST_HEIGHT_M


def test_odometry_without_faults_is_exact() -> None:
    driver = robot()
    start = true_pose(driver)
    driver.drive(Velocity(0.05, 0.05 / 1.5))
    driver.wait(20.0)
    error = (start @ odometry_pose(driver)).inverse() @ true_pose(driver)
    np.testing.assert_allclose([error.x, error.y, error.yaw], 0, atol=1e-3)
    assert odometry_pose(driver).yaw == pytest.approx(20 * 0.05 / 1.5, abs=0.01)


def test_the_same_seed_gives_the_same_run_for_any_time_steps() -> None:
    one, same, other = (robot(slip=0.05, seed=seed) for seed in (1, 1, 2))
    for driver, pieces in ((one, 4), (same, 40), (other, 4)):
        driver.drive(ROUND)
        for _ in range(pieces):
            driver.wait(4.0 / pieces)
        assert driver.now == pytest.approx(4.0)
    np.testing.assert_array_equal(matrix(one), matrix(same))
    assert not np.array_equal(matrix(one), matrix(other))


def test_a_frame_carries_odometry_and_mount_but_no_pose() -> None:
    driver = robot()
    driver.drive(ROUND)
    driver.wait(1.0)
    frame = driver.observe()
    assert frame.T_map_camera is None
    assert frame.odometry is not None
    assert frame.odometry.stamp == frame.stamp == driver.now == driver.truth().stamp
    np.testing.assert_allclose(
        (driver.truth().T_map_base * frame.T_base_camera).as_matrix(),
        driver.truth().T_map_camera.as_matrix(),
    )


def test_the_camera_stands_over_the_left_wheel_and_looks_left_and_down() -> None:
    T = CameraMount(1.1, np.radians(25)).T_base_camera
    np.testing.assert_allclose(T.translation, [0, 0.165, 1.1])
    right, down, forward = T.rotation.as_matrix().T
    np.testing.assert_allclose(right, [1, 0, 0], atol=1e-12)
    expected = [0, np.cos(np.radians(25)), -np.sin(np.radians(25))]
    np.testing.assert_allclose(forward, expected, atol=1e-12)
    assert down[2] < 0


def test_the_depth_is_that_of_the_true_pose() -> None:
    driver = robot()
    driver.drive(ROUND)
    driver.wait(2.0)
    frame = driver.observe()
    points = frame.at(driver.truth().T_map_camera).points_map()
    outside = np.maximum(np.abs(points - [0, 0, 0.35]) - [0.3, 0.3, 0.35], 0).max(axis=1)
    on_floor = np.abs(points[:, 2]) < 1e-4
    assert outside[~on_floor].max() < 1e-4
    assert (~on_floor).sum() > 100


def test_slip_makes_odometry_overestimate_the_distance() -> None:
    claimed, driven = [], []
    for seed in range(10):
        driver = robot(EMPTY, PlanarPose(), seed, slip=0.05)
        driver.drive(Velocity(0.6))
        driver.wait(5.0)
        claimed.append(odometry_pose(driver).x)
        driven.append(np.hypot(*true_pose(driver).xy))
    assert np.mean(driven) / np.mean(claimed) == pytest.approx(0.95, abs=0.012)


def test_slip_is_not_symmetric() -> None:
    yaws = []
    for seed in range(6):
        driver = robot(EMPTY, PlanarPose(), seed, slip=0.05)
        driver.drive(Velocity(0.6))
        driver.wait(5.0)
        assert odometry_pose(driver).yaw == pytest.approx(0, abs=0.01)
        yaws.append(true_pose(driver).yaw)
    assert np.std(yaws) > 0.02


def test_a_larger_right_wheel_turns_left_without_a_trace_in_odometry() -> None:
    driver = robot(EMPTY, PlanarPose(), wheel_radius_error=0.02)
    driver.drive(Velocity(0.5))
    driver.wait(4.0)
    distance = odometry_pose(driver).x
    assert odometry_pose(driver).yaw == pytest.approx(0, abs=2e-3)
    assert true_pose(driver).yaw == pytest.approx(0.02 * distance / 0.33, rel=0.05)


def test_bumps_tilt_the_true_camera_but_not_the_mount() -> None:
    tilts = {}
    for height in (0.0, 0.015):
        driver = robot(EMPTY, PlanarPose(), bump_height=height)
        mounted = driver.T_base_camera.as_matrix()
        driver.drive(Velocity(0.3, 0.2))
        found = []
        for _ in range(80):
            driver.wait(0.25)
            up = driver.truth().T_map_base.rotation.as_matrix()[2, 2]
            found.append(np.degrees(np.arccos(min(up, 1.0))))
        tilts[height] = max(found)
        np.testing.assert_array_equal(driver.T_base_camera.as_matrix(), mounted)
    assert tilts[0.0] < 0.1
    assert 0.5 < tilts[0.015] < 8


@pytest.mark.parametrize(("speed", "spins"), [(0.05, False), (0.8, True)])
def test_a_wall_stops_the_robot_and_slow_wheels_stall(speed: float, spins: bool) -> None:
    wall = Surface("wall", block((0.6, -3, 0), (0.65, 3, 2)))
    scene = Scene((Surface("floor", floor(5.0)), wall))
    driver = robot(scene, PlanarPose())
    driver.drive(Velocity(speed))
    driver.wait(0.6 / speed + 5.0)
    nose = true_pose(driver).x + 0.1825
    assert nose == pytest.approx(0.6, abs=0.06)
    assert (odometry_pose(driver).x > 0.6) == spins


def test_the_robot_does_not_drive_under_a_table_that_its_mast_would_hit() -> None:
    top = Surface("object", block((0.6, -1, 0.7), (2.0, 1, 0.75)))
    driver = robot(Scene((Surface("floor", floor(5.0)), top)), PlanarPose())
    driver.drive(Velocity(0.4))
    driver.wait(5.0)
    assert true_pose(driver).x + 0.1825 == pytest.approx(0.6, abs=0.06)


def test_too_fast_commands_are_clipped() -> None:
    driver = robot(EMPTY, PlanarPose())
    driver.drive(Velocity(5.0))
    driver.wait(4.0)
    assert driver.odometry().forward == pytest.approx(driver.max_forward, rel=0.01)
    driver.stop()
    driver.wait(4.0)
    assert driver.odometry().forward == pytest.approx(0, abs=1e-3)


def test_odometry_does_not_notice_a_displaced_robot() -> None:
    driver = robot()
    before = odometry_pose(driver)
    driver.place(PlanarPose(2.0, -1.0, 0.3))
    driver.wait(0.1)
    np.testing.assert_allclose(true_pose(driver).xy, [2.0, -1.0], atol=2e-3)
    np.testing.assert_allclose(odometry_pose(driver).xy, before.xy, atol=1e-3)


def test_noise_depends_on_the_seed_only() -> None:
    one, same, other = (
        SimulatedRobot(BOX, ON_CIRCLE, noise=DepthNoise(), intrinsics=CAMERA, seed=seed)
        for seed in (3, 3, 4)
    )
    depths = [driver.observe().depth for driver in (one, same, other)]
    np.testing.assert_array_equal(depths[0], depths[1])
    assert not np.array_equal(depths[0], depths[2], equal_nan=True)


def test_real_time_waits() -> None:
    driver = SimulatedRobot(EMPTY, PlanarPose(), intrinsics=CAMERA, real_time=5.0)
    began = time.monotonic()
    driver.wait(1.0)
    assert time.monotonic() - began >= 0.19


@pytest.mark.parametrize(
    "wrong",
    [{"slip": 0.6}, {"slip": -0.1}, {"wheel_radius_error": np.nan}, {"bump_height": 1.0}],
)
def test_impossible_settings_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError):
        RobotSettings(**wrong)


@pytest.mark.parametrize("seconds", [-1.0, np.nan, np.inf])
def test_time_passes_forward(seconds: float) -> None:
    with pytest.raises(InputError, match="forward"):
        robot(EMPTY).wait(seconds)


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan])
def test_real_time_needs_a_positive_factor(factor: float) -> None:
    with pytest.raises(InputError, match="real_time must be positive"):
        SimulatedRobot(EMPTY, PlanarPose(), real_time=factor)


@pytest.mark.parametrize(
    "wrong",
    [
        {"height": 0.0}, {"height": 0.001}, {"height": 1e30}, {"height": np.nan},
        {"tilt": np.pi / 2}, {"tilt": np.nan}, {"left": 1.5},
    ],
)  # fmt: skip
def test_an_impossible_mast_height_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError, match="mast"):
        CameraMount(**wrong)


def test_the_lowest_mast_fits_on_a_robot() -> None:
    SimulatedRobot(EMPTY, PlanarPose(), CameraMount(MIN_MAST_HEIGHT_M))


def test_without_mujoco_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r'pip install "circumspect\[sim\]"'):
        robot(EMPTY)


def matrix(driver: SimulatedRobot) -> np.ndarray:
    T: RigidTransform = driver.truth().T_map_camera
    return T.as_matrix()


def test_a_deleted_robot_is_freed_with_its_simulation() -> None:
    gc.disable()
    try:
        driver = robot()
        driver.camera.capture()
        kept = weakref.ref(driver)
        del driver
        assert kept() is None
    finally:
        gc.enable()
