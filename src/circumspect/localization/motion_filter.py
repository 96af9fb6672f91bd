"""Kalman filter with constant velocity for the motion between measurements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.localization.fusion import difference

SPEED_SIGMA, TURN_SIGMA = 0.5, 1.0
"""Initial standard deviation of the velocity [m/s], [rad/s]."""


class MotionFilter:
    """State x, y, yaw and their rates in map; accelerations are white noise.

    x⁻ = F x, P⁻ = F P Fᵀ + q [[Δt³/3, Δt²/2], [Δt²/2, Δt]] for each axis, with q the square of the
    acceleration's density.
    """

    def __init__(
        self,
        stamp: float,
        pose: PlanarPose,
        covariance: NDArray[np.float64],
        acceleration: float,
        turn_acceleration: float,
    ) -> None:
        """Start at a measured pose.

        Args:
            stamp: Time [s].
            pose: Pose of the robot.
            covariance: (3, 3) of x, y [m] and yaw [rad].
            acceleration: Spectral density of the acceleration [m/s² per √Hz].
            turn_acceleration: Spectral density of the angular acceleration [rad/s² per √Hz].
        """
        self.stamp = stamp
        self._pose = pose
        self._rates = np.zeros(3)
        self._P = np.zeros((6, 6))
        self._P[:3, :3] = covariance
        self._P[3:, 3:] = np.diag(np.square([SPEED_SIGMA, SPEED_SIGMA, TURN_SIGMA]))
        self._q = np.diag(np.square([acceleration, acceleration, turn_acceleration]))

    @property
    def pose(self) -> PlanarPose:
        """Pose at the last stamp."""
        return self._pose

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) covariance of x, y [m] and yaw [rad] at the last stamp."""
        return self._P[:3, :3].copy()

    @property
    def rates(self) -> NDArray[np.float64]:
        """(3,) velocity in x, y [m/s] and yaw [rad/s]."""
        return self._rates.copy()

    def advance(self, stamp: float) -> None:
        """Predict the state at a later time.

        Raises:
            InputError: The stamp is not later.
        """
        seconds = stamp - self.stamp
        if seconds < 0:
            raise InputError(f"time goes forward, not from {self.stamp} to {stamp} s")
        F = np.eye(6)
        F[:3, 3:] = seconds * np.eye(3)
        added = np.block(
            [
                [self._q * seconds**3 / 3, self._q * seconds**2 / 2],
                [self._q * seconds**2 / 2, self._q * seconds],
            ]
        )
        self._P = F @ self._P @ F.T + added
        self._pose = shifted(self._pose, seconds * self._rates)
        self.stamp = stamp

    def update(self, pose: PlanarPose, covariance: NDArray[np.float64]) -> None:
        """Update with a measurement at the current time.

        Args:
            pose: Measured pose.
            covariance: (3, 3) of its noise.
        """
        innovation = difference(pose, self._pose)
        K = np.linalg.solve(self._P[:3, :3] + covariance, self._P[:3]).T
        change = K @ innovation
        self._pose = shifted(self._pose, change[:3])
        self._rates = self._rates + change[3:]
        # Joseph's form stays positive.
        rest = np.eye(6)
        rest[:, :3] -= K
        P = rest @ self._P @ rest.T + K @ covariance @ K.T
        self._P = (P + P.T) / 2


def shifted(pose: PlanarPose, change: NDArray[np.float64]) -> PlanarPose:
    """A pose with x, y and yaw changed."""
    return PlanarPose(*(np.array([pose.x, pose.y, pose.yaw]) + change))
