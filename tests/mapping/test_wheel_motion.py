"""Motions by wheels whose grip is learnt later."""

from __future__ import annotations

from functools import reduce

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import T_BASE_CAMERA

from circumspect.geometry import PlanarPose, se3
from circumspect.mapping.motion import Belief, MotionSettings
from circumspect.mapping.wheel_grip import WheelGrip
from circumspect.mapping.wheel_motion import WheelMotion, wheel_step
from circumspect.sensing import Odometry

SETTINGS = MotionSettings()
MOUNTS = (T_BASE_CAMERA, T_BASE_CAMERA * se3.exp([0.0, 0.2, 0.0, 0.01, 0.0, 0.0]))
"""A head that pans."""

steps = st.builds(
    PlanarPose, st.floats(-0.05, 0.05), st.floats(-0.01, 0.01), st.floats(-0.05, 0.05)
)
drives = st.lists(steps, min_size=1, max_size=12)
shares = st.floats(0.9, 1.05)


def known(way: float, turn: float) -> WheelGrip:
    return WheelGrip((1e4, 1e4), (1e4 * way, 1e4 * turn))


def step_of(told: PlanarPose, mounts=(T_BASE_CAMERA, T_BASE_CAMERA), unheld=(0.0, 0.0)):
    before, now = Odometry(0.0, PlanarPose(1.0, 2.0, 0.3)), PlanarPose(1.0, 2.0, 0.3) @ told
    return wheel_step(before, Odometry(1.0, now), mounts, SETTINGS, unheld)


def scaled(told: PlanarPose, way: float, turn: float) -> RigidTransform:
    return PlanarPose(way * told.x, way * told.y, turn * told.yaw).as_transform()


def test_no_motion_is_known_exactly() -> None:
    belief = WheelMotion.none().by(WheelGrip())
    np.testing.assert_allclose(belief.T_map_camera.as_matrix(), np.eye(4))
    assert not belief.covariance.any()


@given(drives)
def test_wheels_that_grip_are_followed_exactly(told: list[PlanarPose]) -> None:
    motion = reduce(WheelMotion.then, map(step_of, told), WheelMotion.none())
    whole = reduce(PlanarPose.__matmul__, told).as_transform()
    true = T_BASE_CAMERA.inv() * whole * T_BASE_CAMERA
    found = motion.by(WheelGrip()).T_map_camera
    np.testing.assert_allclose(found.as_matrix(), true.as_matrix(), atol=1e-12)


@given(drives, shares, shares)
def test_a_grip_learnt_later_is_as_good_as_one_known_before(
    told: list[PlanarPose], way: float, turn: float
) -> None:
    motion = reduce(WheelMotion.then, map(step_of, told), WheelMotion.none())
    slipped = reduce(RigidTransform.__mul__, [scaled(step, way, turn) for step in told])
    true = T_BASE_CAMERA.inv() * slipped * T_BASE_CAMERA
    error = se3.log(true.inv() * motion.by(known(way, turn)).T_map_camera)
    # To first order; the second of 0.6 m and 0.6 rad with a tenth lost is this large.
    assert np.abs(error[:3]).max() < 5e-4
    assert np.abs(error[3:]).max() < 5e-3


@given(steps, shares, shares)
def test_a_panning_head_goes_with_the_base(told: PlanarPose, way: float, turn: float) -> None:
    true = MOUNTS[0].inv() * scaled(told, way, turn) * MOUNTS[1]
    found = step_of(told, MOUNTS).by(known(way, turn)).T_map_camera
    assert np.abs(se3.log(true.inv() * found)).max() < 2e-5


@given(drives)
def test_the_noise_of_steps_adds_up_as_that_of_a_belief_which_moves(
    told: list[PlanarPose],
) -> None:
    belief, motion = Belief(RigidTransform.identity(), np.zeros((6, 6))), WheelMotion.none()
    for number, step in enumerate(told):
        one = step_of(step, unheld=(0.05 * number, 0.05 * number))
        motion, taken = motion.then(one), one.by(WheelGrip())
        belief = belief.moved(taken.T_map_camera, taken.covariance)
    np.testing.assert_allclose(motion.by(WheelGrip()).covariance, belief.covariance, atol=1e-12)


def test_what_a_steady_slip_costs_goes_as_the_grip_becomes_known() -> None:
    far = step_of(PlanarPose(0.05, 0.0, 0.0), unheld=(1.0, 0.0))
    nothing, little, much = (
        np.trace(far.by(grip).covariance)
        for grip in (WheelGrip(), WheelGrip((0.3, 0.5), (0.3, 0.5)), known(0.95, 0.95))
    )
    assert nothing - much == pytest.approx(2 * (0.05 * SETTINGS.slip**2) * 1.0, rel=1e-2)
    assert little - much == pytest.approx((nothing - much) / 4, rel=1e-2)
