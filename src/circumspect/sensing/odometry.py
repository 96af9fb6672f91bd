"""What the wheels say."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.geometry.frozen_array import ReadOnlyArrays


@dataclass(frozen=True, eq=False)
class Odometry(ReadOnlyArrays):
    """Dead reckoning since the start: smooth, but drifting (REP 105).

    Attributes:
        stamp: Time [s].
        T_odom_base: Where the robot believes to be.
        covariance: (3, 3) of x, y [m] and yaw [rad] in the odom frame, grown since the start.
        forward: Velocity [m/s].
        turn: Rate [rad/s], counter-clockwise.

    Raises:
        InputError: A value is not finite, or the covariance is not (3, 3) or not symmetric.
    """

    stamp: float
    T_odom_base: PlanarPose
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 3)))
    forward: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        covariance = np.array(self.covariance, dtype=np.float64)
        if covariance.shape != (3, 3) or not np.allclose(covariance, covariance.T):
            raise InputError("the covariance of odometry must be symmetric with shape (3, 3)")
        if not np.isfinite([self.stamp, self.forward, self.turn, *covariance.ravel()]).all():
            raise InputError(f"the odometry at {self.stamp} s is not finite")
        covariance.flags.writeable = False
        object.__setattr__(self, "covariance", covariance)
