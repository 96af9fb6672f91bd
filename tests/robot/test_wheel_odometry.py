from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.robot import DifferentialDrive, WheelOdometry
from circumspect.sensing import Odometry

TURNS = st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=1, max_size=12)


def driven(wheels: WheelOdometry, turns: list[tuple[float, float]]) -> list[Odometry]:
    angles = np.cumsum([(0.0, 0.0), *turns], axis=0)
    return [wheels.update(0.1 * i, *pair) for i, pair in enumerate(angles.tolist())]


@settings(max_examples=50)
@given(turns=TURNS)
def test_the_pose_is_the_product_of_the_motions(turns: list[tuple[float, float]]) -> None:
    pose = PlanarPose()
    for pair in turns:
        pose = pose @ DifferentialDrive().motion(*pair)
    between = driven(WheelOdometry(), turns)[-1].T_odom_base.inverse() @ pose
    np.testing.assert_allclose([between.x, between.y, between.yaw], 0, atol=1e-9)


@settings(max_examples=50)
@given(turns=TURNS)
def test_the_covariance_stays_positive_and_the_heading_variance_grows(
    turns: list[tuple[float, float]],
) -> None:
    covariances = [o.covariance for o in driven(WheelOdometry(), turns)]
    np.testing.assert_array_equal(covariances[0], 0)
    for before, after in pairwise(covariances):
        assert after[2, 2] >= before[2, 2]
        assert np.linalg.eigvalsh(after).min() >= -1e-15


def test_after_a_metre_the_covariance_has_full_rank() -> None:
    covariance = driven(WheelOdometry(), [(1.0, 1.0)] * 10)[-1].covariance
    assert np.linalg.eigvalsh(covariance).min() > 1e-9
    assert np.linalg.cond(covariance) < 1e6


def test_variances_of_a_straight_drive_follow_the_formulas() -> None:
    k, travel, track = 4e-4, 3.0, 0.33
    turned = travel / 0.0975 / 300
    covariance = driven(WheelOdometry(travel_variance=k), [(turned, turned)] * 300)[-1].covariance
    assert covariance[0, 0] == pytest.approx(k * travel / 2, rel=1e-6)
    assert covariance[2, 2] == pytest.approx(2 * k * travel / track**2, rel=1e-6)
    # The heading's random walk, integrated along the way: σ_y² = q s³ / 3.
    assert covariance[1, 1] == pytest.approx(2 * k / track**2 * travel**3 / 3, rel=0.01)


def test_the_covariance_hardly_depends_on_the_reading_interval() -> None:
    coarse = driven(WheelOdometry(), [(0.9, 1.0)] * 20)[-1]
    fine = driven(WheelOdometry(), [(0.09, 0.1)] * 200)[-1]
    np.testing.assert_allclose(fine.T_odom_base.xy, coarse.T_odom_base.xy, atol=1e-12)
    np.testing.assert_allclose(fine.covariance, coarse.covariance, rtol=0.02, atol=1e-6)


def test_expected_slip_reduces_distance_rotation_and_speeds() -> None:
    plain = driven(WheelOdometry(), [(0.9, 1.0)])[-1]
    slipping = driven(WheelOdometry(expected_slip=0.1), [(0.9, 1.0)])[-1]
    assert slipping.T_odom_base.yaw == pytest.approx(0.9 * plain.T_odom_base.yaw)
    assert slipping.forward == pytest.approx(0.9 * plain.forward)
    assert slipping.turn == pytest.approx(0.9 * plain.turn)


def test_speeds_are_those_of_the_last_reading() -> None:
    odometry = driven(WheelOdometry(), [(1.0, 1.0), (0.0, 0.0)])
    assert odometry[1].forward == pytest.approx(0.0975 / 0.1)
    assert odometry[2].forward == 0


def test_the_first_reading_is_the_origin_for_any_encoder_value() -> None:
    assert WheelOdometry().update(5.0, 123.0, -7.0).T_odom_base == PlanarPose()


@pytest.mark.parametrize("reading", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, np.nan)])
def test_broken_encoders_are_refused(reading: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="finite"):
        WheelOdometry().update(*reading)


@pytest.mark.parametrize(
    "wrong", [{"expected_slip": 1.0}, {"expected_slip": -0.1}, {"travel_variance": 0.0}]
)
def test_impossible_parameters_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError):
        WheelOdometry(**wrong)
