"""Odometry and poses in messages of ROS."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.recording.pose_messages import (
    odometry_message,
    odometry_of,
    transform_of,
)
from circumspect.recording.ros_time import header, nanoseconds
from circumspect.sensing import Odometry

PLACES = st.floats(-100, 100)
STAMPS = st.floats(0, 2e9)


@given(PLACES, PLACES, st.floats(-3.1, 3.1), STAMPS, st.integers(0, 2**31))
def test_odometry_round_trip(x: float, y: float, yaw: float, stamp: float, seed: int) -> None:
    half = np.random.default_rng(seed).normal(size=(3, 3))
    msg = Odometry(stamp, PlanarPose(x, y, yaw), half @ half.T, 0.1, -0.2)
    found = odometry_of(odometry_message(msg, "odom", "base_link"))
    assert found.T_odom_base.xy == pytest.approx([x, y])
    assert found.T_odom_base.yaw == pytest.approx(yaw, abs=1e-12)
    assert found.stamp == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_allclose(found.covariance, msg.covariance)
    assert (found.forward, found.turn) == (0.1, -0.2)
    # What was recorded once is not changed by being recorded again.
    again = odometry_of(odometry_message(found, "odom", "base_link"))
    assert again.stamp == found.stamp


@pytest.mark.parametrize("fault", ["quaternion", "place", "velocity"])
def test_invalid_odometry_is_refused(fault: str) -> None:
    msg = odometry_message(Odometry(1.0, PlanarPose()), "odom", "base_link")
    if fault == "quaternion":
        msg.pose.pose.orientation.w = 0.0
    elif fault == "place":
        msg.pose.pose.position.x = np.nan
    else:
        msg.twist.twist.linear.x = np.inf
    with pytest.raises(InputError):
        odometry_of(msg)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_covariance_that_is_not_finite_becomes_zero(bad: float) -> None:
    msg = odometry_message(Odometry(1.0, PlanarPose(1, 2, 3), np.eye(3)), "odom", "base_link")
    msg.pose.covariance[:] = bad
    assert not odometry_of(msg).covariance.any()


@pytest.mark.parametrize("stamp", [-0.1, 2.0**31, 1e300])
def test_stamps_outside_the_range_of_ros_are_refused(stamp: float) -> None:
    with pytest.raises(InputError, match="can not be recorded"):
        header(stamp, "map")


@given(STAMPS)
def test_stamps_are_kept_to_the_nanosecond(stamp: float) -> None:
    assert nanoseconds(nanoseconds(stamp) / 1e9) == nanoseconds(stamp)


@pytest.mark.parametrize("far", [1e10, 1.7e308, float("inf"), float("nan")])
def test_absurd_numbers_are_refused_without_a_warning(far: float) -> None:
    place, orientation = SimpleNamespace(x=far, y=0, z=0), SimpleNamespace(x=far, y=0, z=0, w=1)
    with pytest.raises(InputError, match="invalid pose at"):
        transform_of(place, orientation)
    with pytest.raises(InputError, match="invalid pose at"):
        transform_of(place, SimpleNamespace(x=0, y=0, z=0, w=1))
