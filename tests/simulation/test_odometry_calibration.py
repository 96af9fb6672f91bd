from __future__ import annotations

from itertools import pairwise

import numpy as np
from robot_world import EMPTY, odometry_pose, robot, true_pose

from circumspect.geometry import PlanarPose
from circumspect.robot import Velocity
from circumspect.simulation import SimulatedRobot

RUNS = 60
SEGMENT_M = 0.6
"""Length of a segment [m]."""


def segments(slip: float, expected_slip: float) -> np.ndarray:
    """(runs, 2): normalised error squared after 4.8 m on a circle, and mean over its segments."""
    results = []
    for seed in range(RUNS):
        driver = robot(EMPTY, PlanarPose(), 100 + seed, slip=slip, expected_slip=expected_slip)
        driver.drive(Velocity(0.8, 0.8 / 1.2))
        start = true_pose(driver)
        places = [(PlanarPose(), PlanarPose(), np.zeros((3, 3)))]
        for _ in range(8):
            driver.wait(SEGMENT_M / 0.8)
            covariance = driver.odometry().covariance
            places.append((odometry_pose(driver), start.inverse() @ true_pose(driver), covariance))
        pairs = pairwise(places)
        results.append(
            (normalised(places[0], places[-1]), np.mean([normalised(*pair) for pair in pairs]))
        )
    return np.array(results)


Place = tuple[PlanarPose, PlanarPose, np.ndarray]


def normalised(before: Place, after: Place) -> float:
    """Squared error of the measured motion, normalised by the covariance that it added."""
    measured, true = before[0].inverse() @ after[0], before[1].inverse() @ after[1]
    dx, dy = after[0].xy - before[0].xy
    F = np.array([[1, 0, -dy], [0, 1, dx], [0, 0, 1]])
    c, s = before[0].heading_xy
    R = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    added = R @ (after[2] - F @ before[2] @ F.T) @ R.T
    turned = PlanarPose(yaw=measured.yaw - true.yaw).yaw
    error = np.array([measured.x - true.x, measured.y - true.y, turned])
    return float(error @ np.linalg.solve(added, error))


def test_the_covariance_is_calibrated_for_the_expected_slip() -> None:
    whole, each = segments(0.05, 0.05).mean(axis=0)
    assert 2.0 < whole < 4.5
    assert 2.3 < each < 3.7


def test_the_covariance_is_too_large_without_slip_and_too_small_with_more() -> None:
    def on_one_segment(slip: float) -> float:
        driver: SimulatedRobot = robot(EMPTY, PlanarPose(), 1, slip=slip, expected_slip=slip)
        driver.drive(Velocity(0.8, 0.8 / 1.2))
        start = true_pose(driver)
        driver.wait(6.0)
        first = (PlanarPose(), PlanarPose(), np.zeros((3, 3)))
        last = (
            odometry_pose(driver),
            start.inverse() @ true_pose(driver),
            driver.odometry().covariance,
        )
        return normalised(first, last)

    assert on_one_segment(0.0) < 0.1
    assert on_one_segment(0.3) > 9
