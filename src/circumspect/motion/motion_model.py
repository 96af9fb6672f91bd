"""Prediction of the camera's motion between two frames."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.motion.pose_with_covariance import RelativeMotion
from circumspect.sensing import Odometry, RgbdFrame

MAX_STEP_M = 100.0
"""A longer odometry step between two frames [m] is a counter overflow or a corrupt message."""
MAX_UNMEASURED_S, MAX_VARIANCE = 1e3, 1e6
"""Bounds that keep covariances invertible in double precision [s; m², rad²]."""
MAX_GROWTH = 1e100
"""Larger covariances overflow in double precision."""
MAX_EXTRAPOLATION = 2.5
"""A velocity is extrapolated over at most this multiple of the time of its measurement."""
MIN_GROWTH_RATIO, ROUNDING = -0.01, 1e-6
"""Smallest eigenvalue, relative to the largest, of the growth of a dead-reckoning covariance.
Differences below `ROUNDING` of the covariance are rounding errors."""
PLANAR, LEVEL = [3, 4, 2], [0, 1, 5]
"""Indices of x, y and yaw, and of roll, pitch and height, in a tangent vector of the base."""


@dataclass(frozen=True)
class MotionSettings:
    """Uncertainty of the motion between frames.

    Attributes:
        level_rotation: Standard deviation of roll and pitch of a robot on an even floor [rad].
        level_height: Standard deviation of its height [m].
        odometry_noise: Standard deviation of odometry as a fraction of distance and of rotation, in
            addition to the error of its scale.
        min_translation_sigma, min_rotation_sigma: Lower bounds of a step's standard deviation
            [m], [rad].
        speed_sigma, spin_sigma: Standard deviation of a velocity that is assumed to be constant
            [m/s], [rad/s] …
        acceleration_sigma, spin_acceleration_sigma: … limited by what such accelerations [m/s²],
            [rad/s²] change between two frames.
        max_extrapolation: Maximum time over which a velocity is extrapolated after its measurement
            [s].
    """

    level_rotation: float = float(np.radians(0.3))
    level_height: float = 0.004
    odometry_noise: float = 0.03
    min_translation_sigma: float = 0.001
    min_rotation_sigma: float = float(np.radians(0.05))
    speed_sigma: float = 0.3
    spin_sigma: float = float(np.radians(25.0))
    acceleration_sigma: float = 3.0
    spin_acceleration_sigma: float = 6.0
    max_extrapolation: float = 0.7

    @property
    def level_covariance(self) -> NDArray[np.floating]:
        """(3, 3) of roll [rad], pitch [rad] and height [m] of the base."""
        return np.diag([self.level_rotation**2, self.level_rotation**2, self.level_height**2])


@dataclass(frozen=True)
class MotionModel:
    """Predicts the motion between two frames.

    Attributes:
        settings: Uncertainties.
    """

    settings: MotionSettings = MotionSettings()

    def by_odometry(self, before: RgbdFrame, now: RgbdFrame) -> RelativeMotion | None:
        """The motion that wheel odometry reports.

        A mount that changes between the frames, such as a pan-tilt head, is taken into account.

        Returns:
            None if a frame has no odometry, the later one has no mount, or the step is implausible.
        """
        if before.odometry is None or now.odometry is None or now.T_base_camera is None:
            return None
        step = before.odometry.T_odom_base.inverse() @ now.odometry.T_odom_base
        if np.abs(step.xy).max() > MAX_STEP_M:
            return None
        second = now.T_base_camera.as_matrix()
        first = second if before.T_base_camera is None else before.T_base_camera.as_matrix()
        to_camera = se3_matrices.adjoint(se3_matrices.inverse(second))
        cosine, sine = np.cos(step.yaw), np.sin(step.yaw)
        by_scale = np.zeros((6, 2))
        by_scale[3:5, 0] = cosine * step.x + sine * step.y, cosine * step.y - sine * step.x
        by_scale[2, 1] = step.yaw
        distance, rotation = float(np.hypot(step.x, step.y)), abs(step.yaw)
        covariance = self._base_covariance(before.odometry, now.odometry, distance, rotation)
        return RelativeMotion(
            se3_matrices.inverse(first) @ step.as_matrix() @ second,
            to_camera @ by_scale,
            to_camera @ covariance @ to_camera.T,
        )

    def by_slipping_wheels(
        self,
        odometry: RelativeMotion,
        T_base_camera: NDArray[np.floating],
        T_before_measured: NDArray[np.floating],
        distance: float,
        rotation: float,
    ) -> RelativeMotion:
        """No motion since the last measurement; the reported one is a standard deviation.

        Args:
            odometry: The reported motion.
            T_base_camera: (4, 4) mount of the camera.
            T_before_measured: (4, 4) pose of the camera at the last measurement, relative to the
                pose before the motion.
            distance: Predicted distance between both poses [m].
            rotation: Predicted rotation between both poses [rad].
        """
        to_camera = se3_matrices.adjoint(se3_matrices.inverse(T_base_camera))
        variances = np.zeros(6)
        variances[PLANAR[:2]] = (distance + odometry.distance) ** 2
        variances[PLANAR[2]] = (rotation + odometry.rotation) ** 2
        slip = to_camera * variances @ to_camera.T
        return RelativeMotion(
            T_before_measured, np.zeros((6, 2)), odometry.covariance + slip, "slipping wheels"
        )

    def by_constant_velocity(
        self,
        T_before_now: NDArray[np.floating],
        measured: float,
        time: float,
        unmeasured: float,
        time_sigma: float = 0.0,
    ) -> RelativeMotion:
        """Extrapolate the last motion.

        Args:
            T_before_now: (4, 4) the motion in the last `measured` seconds.
            measured: Duration of that motion [s].
            time: Time to extrapolate [s].
            unmeasured: Time since the velocity was measured [s].
            time_sigma: Standard deviation of `time` [s]; frames may be stamped on arrival.
        """
        ratio, change = 0.0, se3_matrices.log(T_before_now)
        if measured > 0:
            left = min(time, max(self.settings.max_extrapolation - unmeasured, 0.0))
            ratio = min(left / measured, MAX_EXTRAPOLATION)
            change = change / measured
        motion = self._by_velocity(
            se3_matrices.exp(ratio * measured * change), time, unmeasured, "constant velocity"
        )
        by_time = time_sigma * change
        return replace(motion, covariance=motion.covariance + np.outer(by_time, by_time))

    def by_standing_still(self, time: float, unmeasured: float) -> RelativeMotion:
        """No motion; arguments as in `by_constant_velocity`."""
        return self._by_velocity(np.eye(4), time, unmeasured, "standing still")

    def _by_velocity(
        self, T_before_now: NDArray[np.floating], time: float, unmeasured: float, source: str
    ) -> RelativeMotion:
        s = self.settings
        since = min(unmeasured, MAX_UNMEASURED_S)
        until = min(since + time, MAX_UNMEASURED_S)
        spin, speed = s.spin_sigma, s.speed_sigma
        rotation = _growth(spin, s.spin_acceleration_sigma, since, until)
        translation = _growth(speed, s.acceleration_sigma, since, until)
        covariance = np.diag([max(rotation, 1e-9)] * 3 + [max(translation, 1e-9)] * 3)
        return RelativeMotion(T_before_now, np.zeros((6, 2)), covariance, source)

    def _base_covariance(
        self, before: Odometry, now: Odometry, distance: float, rotation: float
    ) -> NDArray[np.floating]:
        """(6, 6) covariance of an odometry step in the base frame, without its scale error."""
        s = self.settings
        translation_sigma = s.min_translation_sigma + s.odometry_noise * distance
        rotation_sigma = s.min_rotation_sigma + s.odometry_noise * rotation
        covariance = np.zeros((6, 6))
        covariance[np.ix_(PLANAR, PLANAR)] = _covariance_growth(before, now) + np.diag(
            [translation_sigma**2, translation_sigma**2, rotation_sigma**2]
        )
        covariance[np.ix_(LEVEL, LEVEL)] = s.level_covariance
        return covariance


def _growth(speed_sigma: float, acceleration_sigma: float, since: float, until: float) -> float:
    """Growth of the position variance between two times [s] after the last measurement.

    A velocity error persists: after t seconds the standard deviation is min(speed, acceleration t)
    t. The sum over steps does not depend on the frame rate.
    """
    before, after = (min(speed_sigma, acceleration_sigma * t) * t for t in (since, until))
    return after**2 - before**2


def _covariance_growth(before: Odometry, now: Odometry) -> NDArray[np.floating]:
    """(3, 3) growth of the reported covariance [m, rad], in the current base frame.

    Some drivers report constants or covariances of other poses. Differences with negative
    eigenvalues, and differences that overflow, are replaced by zero.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        growth = now.growth_since(before)
    if not np.abs(growth).max() < MAX_GROWTH:
        return np.zeros((3, 3))
    values, vectors = np.linalg.eigh((growth + growth.T) / 2)
    if values[0] < MIN_GROWTH_RATIO * values[-1] - ROUNDING * np.trace(now.covariance):
        return np.zeros((3, 3))
    return vectors * np.clip(values, 0, MAX_VARIANCE) @ vectors.T
