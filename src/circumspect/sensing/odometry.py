"""What the wheels say."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.geometry.frozen_array import ReadOnlyArrays, frozen


@dataclass(frozen=True, eq=False)
class Odometry(ReadOnlyArrays):
    """Dead reckoning since the start: smooth, but drifting (REP 105).

    Attributes:
        stamp: Time [s].
        T_odom_base: Where the robot believes to be. May be given as one RigidTransform, of which
            height, roll and pitch are left out.
        covariance: (3, 3) of x, y [m] and yaw [rad] in the odom frame, grown since the start.
        forward: Velocity [m/s].
        turn: Rate [rad/s], counter-clockwise.

    Raises:
        InputError: A value is not finite, the pose is of another type, or the covariance is not
            (3, 3) or not symmetric.
    """

    stamp: float
    T_odom_base: PlanarPose
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 3)))
    forward: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_odom_base", _planar(self.T_odom_base))
        covariance = frozen(self.covariance)
        _require_symmetric(covariance)
        if not np.isfinite([self.stamp, self.forward, self.turn, *covariance.ravel()]).all():
            raise InputError(f"the odometry at {self.stamp} s is not finite")
        object.__setattr__(self, "covariance", covariance)


def _planar(pose: object) -> PlanarPose:
    if isinstance(pose, PlanarPose):
        return pose
    if isinstance(pose, RigidTransform) and pose.single:
        return PlanarPose.from_transform(pose)
    raise InputError(
        "T_odom_base must be a circumspect.geometry.PlanarPose(x, y, yaw) or one RigidTransform, "
        f"not {type(pose).__name__}"
    )


def _require_symmetric(covariance: NDArray[np.float64]) -> None:
    if covariance.shape in ((6, 6), (36,)):
        raise InputError(
            "the covariance of odometry is that of x, y and yaw, (3, 3): take rows and columns 0, "
            "1 and 5 of a (6, 6) one from ROS"
        )
    if covariance.shape != (3, 3) or not np.allclose(covariance, covariance.T):
        raise InputError("the covariance of odometry must be symmetric with shape (3, 3)")
