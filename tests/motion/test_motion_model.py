"""Predicted motions against geometry, against derivatives, and with odd odometry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, PlanarPose, se3_matrices
from circumspect.motion import MotionModel, MotionSettings
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.simulation import looking_at

CAMERA = PinholeCamera(8, 6, 7.0, 7.0, 3.5, 2.5)
MOUNT = looking_at((0.1, 0.0, 1.1), (0.0, 1.5, 0.3))
MODEL = MotionModel()
SMALL = st.floats(-0.5, 0.5)


def frame(
    stamp: float,
    pose: PlanarPose | None,
    covariance: np.ndarray | None = None,
    mount: RigidTransform | None = MOUNT,
) -> RgbdFrame:
    odometry = None
    if pose is not None:
        grown = np.zeros((3, 3)) if covariance is None else covariance
        odometry = Odometry(stamp, pose, grown)
    depth = np.ones((CAMERA.height, CAMERA.width), np.float32)
    return RgbdFrame(depth, CAMERA, stamp, odometry=odometry, T_base_camera=mount)


@given(SMALL, SMALL, st.floats(-1.0, 1.0))
def test_odometry_moves_the_camera_with_the_base(x: float, y: float, yaw: float) -> None:
    before, now = PlanarPose(1.0, 2.0, 0.7), PlanarPose(1.0, 2.0, 0.7) @ PlanarPose(x, y, yaw)
    motion = MODEL.by_odometry(frame(0.0, before), frame(1.0, now))
    assert motion is not None
    first = before.as_matrix() @ MOUNT.as_matrix()
    second = now.as_matrix() @ MOUNT.as_matrix()
    np.testing.assert_allclose(first @ motion.T_before_now, second, atol=1e-12)


def test_the_derivative_by_the_scale_is_that_of_a_scaled_step() -> None:
    """A base that moves straight ahead, and one that turns in place."""
    for step, index in ((PlanarPose(0.4, 0.0, 0.0), 0), (PlanarPose(0.0, 0.0, 0.3), 1)):
        motion = MODEL.by_odometry(frame(0.0, PlanarPose()), frame(1.0, step))
        assert motion is not None
        factor = 1 + 1e-5
        scaled = PlanarPose(step.x * factor, step.y * factor, step.yaw * factor)
        exact = MODEL.by_odometry(frame(0.0, PlanarPose()), frame(1.0, scaled))
        assert exact is not None
        change = se3_matrices.inverse(motion.T_before_now) @ exact.T_before_now
        np.testing.assert_allclose(
            motion.by_scale[:, index], se3_matrices.log(change) / 1e-5, atol=1e-4
        )


def test_a_rotating_mount_moves_the_camera() -> None:
    turned = RigidTransform.from_rotation(
        RigidTransform.from_exp_coords([0, 0, 0.2, 0, 0, 0]).rotation
    )
    motion = MODEL.by_odometry(
        frame(0.0, PlanarPose()), frame(1.0, PlanarPose(), mount=turned * MOUNT)
    )
    assert motion is not None
    angle = np.linalg.norm(se3_matrices.log(motion.T_before_now)[:3])
    assert angle == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("before", "now"),
    [
        (frame(0.0, None), frame(1.0, PlanarPose())),
        (frame(0.0, PlanarPose()), frame(1.0, None)),
        (frame(0.0, PlanarPose()), frame(1.0, PlanarPose(), mount=None)),
        (frame(0.0, PlanarPose()), frame(1.0, PlanarPose(1e4, 0.0, 0.0))),
    ],
    ids=["no odometry before", "no odometry now", "no mount", "overflow"],
)
def test_motion_without_usable_odometry_is_unknown(before: RgbdFrame, now: RgbdFrame) -> None:
    assert MODEL.by_odometry(before, now) is None


def test_a_growing_covariance_is_used_and_a_constant_one_ignored() -> None:
    step, large = PlanarPose(0.1, 0.0, 0.0), np.diag([0.04, 0.04, 0.01])
    grown = MODEL.by_odometry(frame(0.0, PlanarPose()), frame(1.0, step, large))
    constant = MODEL.by_odometry(frame(0.0, PlanarPose(), large), frame(1.0, step, large))
    without = MODEL.by_odometry(frame(0.0, PlanarPose()), frame(1.0, step))
    assert grown is not None
    assert constant is not None
    assert without is not None
    assert np.trace(grown.covariance) > np.trace(without.covariance) + 0.08
    # A constant covariance is not that of dead reckoning. It adds nothing.
    np.testing.assert_allclose(constant.covariance, without.covariance)


@given(SMALL, SMALL, st.floats(-3.0, 3.0), st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9))
def test_a_constant_covariance_adds_nothing_on_any_step(
    x: float, y: float, yaw: float, root: list[float]
) -> None:
    half = np.reshape(root, (3, 3))
    constant, step = half @ half.T, PlanarPose(x, y, yaw)
    motion = MODEL.by_odometry(frame(0.0, PlanarPose(), constant), frame(1.0, step, constant))
    without = MODEL.by_odometry(frame(0.0, PlanarPose()), frame(1.0, step))
    assert motion is not None
    assert without is not None
    added = np.linalg.eigvalsh(motion.covariance - without.covariance)
    assert np.abs(added).max() < 0.05 * max(np.trace(constant), 1e-12)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 1e308])
def test_a_huge_covariance_gives_a_finite_invertible_one(value: float) -> None:
    bad = np.diag([value, value, value])
    step = PlanarPose(0.1, -0.05, 0.2)
    for before, now in ((None, bad), (bad, bad), (bad, None)):
        motion = MODEL.by_odometry(frame(0.0, PlanarPose(), before), frame(1.0, step, now))
        assert motion is not None
        assert np.isfinite(motion.covariance).all()
        assert np.isfinite(np.linalg.inv(motion.covariance)).all()


@given(st.floats(0.01, 1.0), st.floats(0.05, 1.0))
def test_a_constant_velocity_is_continued_in_proportion(time: float, measured: float) -> None:
    velocity = np.array([0.02, -0.1, 0.05, 0.1, 0.02, -0.03])
    motion = MODEL.by_constant_velocity(
        se3_matrices.exp(velocity * measured), measured, time, unmeasured=0.0
    )
    left = min(time, MODEL.settings.max_extrapolation)
    ratio = min(left / measured, 2.5)
    np.testing.assert_allclose(
        se3_matrices.log(motion.T_before_now), velocity * measured * ratio, atol=1e-9
    )
    assert not motion.by_scale.any()


def test_uncertainty_grows_with_the_time_without_measurements() -> None:
    steps = [MODEL.by_standing_still(0.5, unmeasured).covariance[5, 5] for unmeasured in (0, 1, 5)]
    assert steps == sorted(steps)
    # The variance of a wrong velocity after several steps is that of one long step.
    parts = sum(MODEL.by_standing_still(0.5, 0.5 * n).covariance[5, 5] for n in range(4))
    assert parts == pytest.approx((MotionSettings().speed_sigma * 2.0) ** 2)


def test_frequent_frames_are_predicted_better() -> None:
    """Accelerations are limited: at 30 Hz a camera cannot leave its course by much."""
    fast = MODEL.by_constant_velocity(np.eye(4), 1 / 30, 1 / 30, 0.0)
    assert np.sqrt(fast.covariance[5, 5]) < 0.005
    assert np.isfinite(np.linalg.inv(fast.covariance)).all()


def test_covariances_stay_invertible_after_a_long_pause() -> None:
    motion = MODEL.by_standing_still(1e9, 1e9)
    assert np.isfinite(np.linalg.inv(motion.covariance)).all()


@given(st.floats(0.0, 1.0), st.floats(-1.0, 1.0), st.booleans())
def test_the_covariance_includes_slip_by_any_share(share: float, size: float, turns: bool) -> None:
    """From none of it to all, the true motion is within a standard deviation."""
    reported = PlanarPose(0.0, 0.0, size) if turns else PlanarPose(size, 0.0, 0.0)
    odometry = MODEL.by_odometry(frame(0.0, PlanarPose()), frame(1.0, reported))
    assert odometry is not None
    mount = MOUNT.as_matrix()
    motion = MODEL.by_slipping_wheels(odometry, mount, np.eye(4), 0.0, 0.0)
    axis, to_base = 2 if turns else 3, se3_matrices.adjoint(mount)
    sigmas = np.sqrt(np.diag(to_base @ motion.covariance @ to_base.T))
    assert share * abs(size) <= sigmas[axis] + 1e-9
    # What was assumed since the last measurement counts as well.
    longer = MODEL.by_slipping_wheels(odometry, mount, np.eye(4), 1.0, 1.0)
    assert np.linalg.eigvalsh(longer.covariance - motion.covariance).min() > -1e-9


@pytest.mark.parametrize("rate", [2, 30, 100])
def test_uncertainty_without_measurements_does_not_depend_on_the_frame_rate(rate: int) -> None:
    """After one second; a flat wall must not become reliable because frames are frequent."""
    model, covariance = MotionModel(), np.zeros((6, 6))
    for number in range(rate):
        motion = model.by_constant_velocity(np.eye(4), 1 / rate, 1 / rate, number / rate)
        covariance = covariance + motion.covariance
    sigmas = np.sqrt(np.diag(covariance))
    assert sigmas[3] == pytest.approx(model.settings.speed_sigma, rel=0.01)
    assert sigmas[0] == pytest.approx(model.settings.spin_sigma, rel=0.01)
