"""Wheel odometry."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.geometry.frozen_array import ReadOnlyArrays, frozen


@dataclass(frozen=True, eq=False)
class Odometry(ReadOnlyArrays):
    """Dead reckoning since the start: smooth, but with drift (REP 105).

    Attributes:
        stamp: Time [s].
        T_odom_base: Pose of the base. May be given as one RigidTransform, whose height, roll and
            pitch are ignored.
        covariance: (3, 3) of x, y [m] and yaw [rad] in the odom frame, accumulated since the start.
            Zero if unknown; a covariance that is not finite is treated as unknown.
        forward: Velocity [m/s].
        turn: Rate [rad/s], counter-clockwise.

    Raises:
        InputError: A value other than the covariance is not finite, the pose is of another type,
            or the covariance is not (3, 3) or not symmetric.
    """

    stamp: float
    T_odom_base: PlanarPose
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 3)))
    forward: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_odom_base", _planar(self.T_odom_base))
        covariance = frozen(self.covariance)
        if not np.isfinite(covariance).all():
            covariance = frozen(np.zeros_like(covariance))
        _require_symmetric(covariance)
        if not np.isfinite([self.stamp, self.forward, self.turn]).all():
            raise InputError(f"the odometry at {self.stamp} s is not finite")
        object.__setattr__(self, "covariance", covariance)

    def growth_since(self, before: Odometry) -> NDArray[np.float64]:
        """(3, 3) growth of the covariance [m, rad], in the current base frame.

        With F the derivative of the current pose by the previous pose, this is P - F P_before Fᵀ,
        rotated into the base frame. It has no negative eigenvalue if P is that of dead reckoning.

        Args:
            before: An earlier reading.
        """
        F = _derivative(before.T_odom_base, self.T_odom_base)
        turn = _turn(self.T_odom_base.yaw)
        return turn.T @ (self.covariance - F @ before.covariance @ F.T) @ turn

    def grown_from(self, before: Odometry, growth: NDArray[np.float64]) -> Odometry:
        """The same odometry with an accumulated covariance; see `growth_since`.

        Args:
            before: An earlier reading.
            growth: (3, 3) growth since then [m, rad], in the current base frame.
        """
        F = _derivative(before.T_odom_base, self.T_odom_base)
        turn = _turn(self.T_odom_base.yaw)
        covariance = F @ before.covariance @ F.T + turn @ growth @ turn.T
        return replace(self, covariance=(covariance + covariance.T) / 2)


def _derivative(before: PlanarPose, now: PlanarPose) -> NDArray[np.float64]:
    """(3, 3) derivative of a pose by an earlier one, for a constant motion between them."""
    F = np.eye(3)
    F[:2, 2] = before.y - now.y, now.x - before.x
    return F


def _turn(yaw: float) -> NDArray[np.float64]:
    """(3, 3) rotation of changes of x, y, yaw from a base frame with a yaw [rad] to its parent."""
    turn = np.eye(3)
    turn[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    return turn


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
            "the covariance of odometry must be (3, 3) of x, y and yaw: take rows and columns 0, "
            "1 and 5 of a (6, 6) one from ROS"
        )
    if covariance.shape != (3, 3) or not np.allclose(covariance, covariance.T):
        raise InputError("the covariance of odometry must be symmetric with shape (3, 3)")
