"""Path following by pure pursuit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose, wrapped
from circumspect.robot.mobile_robot import Velocity

MIN_SPEED_M_S = 0.02
"""Minimum speed towards the goal [m/s]."""


@dataclass(frozen=True)
class PathFollower:
    """Steers towards a point ahead on the path, and turns on the spot at sharp turns of the path.

    The arc through the robot, tangential to its heading, that meets a point at distance d and
    angle α has the curvature κ = 2 sin(α) / d (Coulter, "Implementation of the Pure Pursuit Path
    Tracking Algorithm", CMU-RI-TR-92-01, 1992).

    Attributes:
        lookahead: Distance along the path from the point nearest to the robot [m].
        max_bearing: Bearing above which the robot turns on the spot first [rad].
        max_turn: Maximum turning rate [rad/s].
        arrive: Distance at which the goal is reached [m] …
        arrive_yaw: … and maximum heading error [rad].
        turn_gain: Turning rate per remaining angle [1/s].
        forward_gain: Speed per remaining distance near the goal [1/s].
    """

    lookahead: float = 0.20
    max_bearing: float = float(np.radians(50.0))
    max_turn: float = 0.5
    arrive: float = 0.05
    arrive_yaw: float = float(np.radians(3.0))
    turn_gain: float = 1.5
    forward_gain: float = 0.8

    def velocity(
        self,
        T_map_base: PlanarPose,
        path_xy: NDArray[np.float64],
        goal: PlanarPose,
        speed: float,
    ) -> Velocity | None:
        """The velocity at a pose.

        Args:
            T_map_base: Pose of the robot.
            path_xy: (n, 2) path [m]; its last point is near the goal.
            goal: Goal pose.
            speed: Maximum forward speed [m/s].

        Returns:
            None once the goal is reached.
        """
        remaining = float(np.linalg.norm(goal.xy - T_map_base.xy))
        if remaining <= self.arrive:
            return self._turned_to(goal.yaw - T_map_base.yaw)
        target = T_map_base.inverse().applied(self._ahead(T_map_base.xy, path_xy, goal))
        angle, distance = float(np.arctan2(target[1], target[0])), float(np.linalg.norm(target))
        if abs(angle) > self.max_bearing:
            return self._turning(angle)
        forward = min(speed, max(MIN_SPEED_M_S, self.forward_gain * remaining))
        curvature = 2 * np.sin(angle) / max(distance, 1e-6)
        return Velocity(forward, forward * float(curvature)).clipped(speed, self.max_turn)

    def _turned_to(self, angle: float) -> Velocity | None:
        angle = wrapped(angle)
        return None if abs(angle) <= self.arrive_yaw else self._turning(angle)

    def _turning(self, angle: float) -> Velocity:
        """Turn on the spot in the shorter direction."""
        return Velocity(0.0, float(np.clip(self.turn_gain * angle, -self.max_turn, self.max_turn)))

    def _ahead(
        self, place_xy: NDArray[np.float64], path_xy: NDArray[np.float64], goal: PlanarPose
    ) -> NDArray[np.float64]:
        """(2,) the point of the path, extended to the goal, to steer to."""
        path = np.vstack([path_xy, goal.xy])
        starts, steps = path[:-1], np.diff(path, axis=0)
        squares = np.maximum(np.einsum("ij,ij->i", steps, steps), 1e-12)
        fraction = np.clip(np.einsum("ij,ij->i", place_xy - starts, steps) / squares, 0, 1)
        nearest = starts + fraction[:, None] * steps
        along = np.concatenate([[0.0], np.cumsum(np.sqrt(squares))])
        best = int(np.argmin(np.linalg.norm(nearest - place_xy, axis=1)))
        wanted = along[best] + fraction[best] * np.sqrt(squares[best]) + self.lookahead
        return np.array([np.interp(wanted, along, axis) for axis in path.T])
