"""Dead reckoning from wheel encoders, with its covariance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.robot.differential_drive import DifferentialDrive, arc
from circumspect.sensing import Odometry

TRAVEL_VARIANCE = 2.5e-4
"""Variance of a wheel's travel per metre of travel [m²/m].

Slip that changes every l metres with a standard deviation s adds s² l: 0.05² times 0.1 m for the
simulated robot with 5 % (see `simulation.WheelSlip`).
"""
SKID_VARIANCE = 1e-6
"""Variance of the sideways motion per metre of travel [m²/m]."""


class WheelOdometry:
    """Integrates encoder angles on exact arcs, with independent errors of the two wheels.

    With u = (Δsᵣ, Δsₗ) the travels of the wheels and x = (x, y, θ),
    P ← F P Fᵀ + G diag(k |Δsᵣ|, k |Δsₗ|, q |Δs|) Gᵀ, where F = ∂x'/∂x and G = ∂x'/∂(u, sideways)
    at the middle of the step's arc (Siegwart, Nourbakhsh and Scaramuzza, "Introduction to
    Autonomous Mobile Robots", 2nd ed. 2011, section 5.2.4).

    The covariance describes random errors with a known mean. A constant error, such as a wrong
    wheel radius or an uncalibrated slip, grows faster.
    """

    def __init__(
        self,
        drive: DifferentialDrive | None = None,
        expected_slip: float = 0.0,
        travel_variance: float = TRAVEL_VARIANCE,
        skid_variance: float = SKID_VARIANCE,
    ) -> None:
        """Start at the origin of the odom frame, without error.

        Args:
            drive: Kinematics; None for a Pioneer 3-DX.
            expected_slip: Mean fraction of the wheel travel lost to slip, from a calibration drive;
                it is subtracted.
            travel_variance: k, see `TRAVEL_VARIANCE` [m²/m].
            skid_variance: q, see `SKID_VARIANCE` [m²/m].

        Raises:
            InputError: The slip or a variance is invalid.
        """
        if not 0 <= expected_slip < 1:
            raise InputError(f"the expected slip must be from 0 to below 1, not {expected_slip}")
        if not (0 < travel_variance < np.inf and 0 < skid_variance < np.inf):
            raise InputError(
                f"variances per metre must be positive, not {travel_variance}, {skid_variance}"
            )
        self._drive = drive or DifferentialDrive()
        self._grip = 1 - expected_slip
        self._variances = np.array([travel_variance, travel_variance, skid_variance])
        self._angles: tuple[float, float, float] | None = None
        self._pose = PlanarPose()
        self._covariance = np.zeros((3, 3))
        self._speeds = (0.0, 0.0)

    def update(self, stamp: float, left: float, right: float) -> Odometry:
        """Add encoder readings.

        Args:
            stamp: Time [s], later than the previous one.
            left: Total angle of the left wheel [rad]; the first reading is zero.
            right: Total angle of the right wheel [rad].

        Raises:
            InputError: A reading is not finite.
        """
        if not np.isfinite([stamp, left, right]).all():
            raise InputError(f"encoder readings must be finite, not {left}, {right} at {stamp} s")
        if self._angles is not None:
            seconds = stamp - self._angles[0]
            turned = (left - self._angles[1], right - self._angles[2])
            self._advance(*turned)
            if seconds > 0:
                self._speeds = (turned[0] / seconds, turned[1] / seconds)
        self._angles = (stamp, left, right)
        velocity = self._drive.velocity(*self._speeds)
        return Odometry(
            stamp,
            self._pose,
            self._covariance,
            self._grip * velocity.forward,
            self._grip * velocity.turn,
        )

    def _advance(self, left: float, right: float) -> None:
        radius = self._grip * self._drive.wheel_radius
        travel_left, travel_right = radius * left, radius * right
        length = (travel_right + travel_left) / 2
        turn = (travel_right - travel_left) / self._drive.track
        before, self._pose = self._pose, self._pose @ arc(length, turn)
        F, G = _jacobians(before.yaw + turn / 2, length, self._drive.track)
        travels = np.abs([travel_right, travel_left, (abs(travel_left) + abs(travel_right)) / 2])
        added = (G * (self._variances * travels)) @ G.T
        covariance = F @ self._covariance @ F.T + added
        self._covariance = (covariance + covariance.T) / 2


def _jacobians(
    heading: float, length: float, track: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """F (3, 3) by the previous pose, and G (3, 3) by right travel, left travel and skid."""
    c, s = np.cos(heading), np.sin(heading)
    F = np.array([[1, 0, -length * s], [0, 1, length * c], [0, 0, 1]])
    bend = length / (2 * track)
    G = np.array(
        [
            [c / 2 - bend * s, c / 2 + bend * s, -s],
            [s / 2 + bend * c, s / 2 - bend * c, c],
            [1 / track, -1 / track, 0],
        ]
    )
    return F, G
