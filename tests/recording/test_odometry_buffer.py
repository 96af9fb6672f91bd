"""The odometry of a frame, among messages that come at other times."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import PlanarPose
from circumspect.recording.odometry_buffer import OdometryBuffer
from circumspect.robot import arc
from circumspect.sensing import Odometry

FORWARD, TURN = 0.5, 0.8


def odometry(stamp: float) -> Odometry:
    """A robot that drives an even arc, at 0.5 m/s on a circle."""
    place = PlanarPose(1.0, -2.0, 0.7) @ arc(FORWARD * stamp, TURN * stamp)
    return Odometry(stamp, place, stamp * np.eye(3), FORWARD, TURN)


def add(interval: float, count: int = 10, silent: bool = False) -> OdometryBuffer:
    """Messages at an interval [s]; silent ones have no velocity."""
    buffer = OdometryBuffer()
    for number in range(count):
        message = odometry(interval * number)
        still = Odometry(message.stamp, message.T_odom_base, message.covariance)
        buffer.add(still if silent else message)
    return buffer


def assert_at(buffer: OdometryBuffer, stamp: float) -> Odometry:
    found, true = buffer.at(stamp), odometry(stamp)
    assert found is not None
    assert found.stamp == stamp
    assert found.T_odom_base.xy == pytest.approx(true.T_odom_base.xy, abs=1e-9)
    off = found.T_odom_base.inverse() @ true.T_odom_base
    assert off.yaw == pytest.approx(0.0, abs=1e-9)
    return found


@given(st.floats(0.01, 0.4), st.floats(0, 8), st.booleans())
def test_odometry_is_interpolated_along_an_arc(
    interval: float, number: float, silent: bool
) -> None:
    stamp = number * interval
    found = assert_at(add(interval, silent=silent), stamp)
    np.testing.assert_allclose(found.covariance, stamp * np.eye(3), atol=1e-9)


@pytest.mark.parametrize("stamp", [1.65, 1.99, 2.15])
def test_odometry_beside_a_gap_is_extrapolated_by_velocity(stamp: float) -> None:
    buffer = add(0.1, 16)
    for later in (2.1, 2.2):
        buffer.add(odometry(later))
    assert_at(buffer, stamp)


def test_the_first_and_last_messages_are_extrapolated_for_a_short_time() -> None:
    buffer = add(0.1)
    for stamp in (-0.15, 1.05):
        assert_at(buffer, stamp)
    assert buffer.at(-0.25) is None
    assert buffer.at(1.15) is None
    held = add(0.1, silent=True).at(1.05)
    assert held is not None
    assert held.T_odom_base == odometry(0.1 * 9).T_odom_base, (
        "without velocity the last pose is kept"
    )


def test_no_odometry_in_the_middle_of_a_gap() -> None:
    buffer = OdometryBuffer()
    assert buffer.at(0.0) is None
    for stamp in (1.0, 1.45):
        buffer.add(odometry(stamp))
    assert buffer.at(1.225) is None
    assert_at(buffer, 1.2)


def test_late_messages_are_skipped_and_exact_stamps_are_not_interpolated() -> None:
    buffer = add(0.1, 13)
    buffer.add(Odometry(1.15, PlanarPose(9.0, 9.0, 1.0)))
    assert_at(buffer, 1.15)
    exact = buffer.at(1.1)
    assert exact is not None
    assert exact.T_odom_base == odometry(0.1 * 11).T_odom_base
    assert buffer.covers(1.2)
    assert not buffer.covers(1.21)


def test_old_odometry_is_dropped() -> None:
    buffer = add(0.1, 1000)
    assert buffer.at(50.0) is None
    assert buffer.at(95.0) is not None


@pytest.mark.parametrize("velocity", [1e9, -1.7e308])
def test_an_absurd_velocity_is_no_fault_inside(velocity: float) -> None:
    buffer = OdometryBuffer()
    for stamp, x in ((0.0, 1e9), (0.1, -1e9)):
        buffer.add(Odometry(stamp, PlanarPose(x, x, x), forward=velocity, turn=velocity))
    for stamp in (-0.1, 0.05, 0.2):
        assert buffer.at(stamp) is not None
