"""A robot that something holds while few points are in range and its wheels spin on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tracking_world import SHORT, follow, place_errors, short_drive

from circumspect.geometry import PlanarPose
from circumspect.registration import Scan
from circumspect.sensing import Odometry, RgbdFrame

HELD = 12
"""Frames of the robot that does not move."""
SPIN_M = 0.02
"""What its wheels report for each."""


def held(rows: int) -> list[RgbdFrame]:
    """The last frame again, with depth in the lowest rows alone, while the wheels spin on."""
    last = short_drive()[-1]
    assert last.odometry is not None
    depth = last.depth.copy()
    depth[: depth.shape[0] - rows] = np.nan
    frames = []
    for number in range(1, HELD + 1):
        spun = last.odometry.T_odom_base @ PlanarPose(SPIN_M * number, 0.0, 0.0)
        grown = last.odometry.covariance + np.diag([(0.05 * SPIN_M) ** 2 * number] * 3)
        stamp = last.stamp + number
        frames.append(
            replace(last, depth=depth, stamp=stamp, odometry=Odometry(stamp, spun, grown))
        )
    return frames


@pytest.mark.parametrize("rows", [16, 12, 8, 0])
def test_a_held_robot_with_few_points_in_range_is_not_reliable_and_wrong(rows: int) -> None:
    frames = held(rows)
    assert len(Scan.from_frame(frames[0])) < 300
    estimates = follow([*short_drive(), *frames])
    errors = place_errors(estimates, np.concatenate([SHORT, np.full(HELD, SHORT[-1])]))
    assert max(errors[[e.reliable for e in estimates]]) < 0.06
    assert max(errors[[e.accurate for e in estimates]]) < 0.03
