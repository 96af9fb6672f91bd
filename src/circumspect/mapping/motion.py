"""Where a camera must be by now, before its picture is looked at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3, se3_matrices
from circumspect.geometry.composition import composed, orthonormal
from circumspect.geometry.pose_distance import distances

ODOMETRY, CONSTANT_VELOCITY = "odometry", "constant velocity"
STANDING_STILL = "standing still"
CLOSE_SHIFT, CLOSE_TURN = 0.015, float(np.radians(1.0))
CLOSE_SHARE = 0.5
"""Predictions within this [m], [rad], or this share of the motion, of each other say the same."""
LONGEST_GUESS, MOST_VARIANCE = 1e3, 1e6
"""After this time [s], and from this variance [m²], [rad²] on, nothing is known anyway; larger ones
are no numbers to calculate with."""


@dataclass(frozen=True)
class MotionSettings:
    """How far a camera may stray.

    Attributes:
        bump_turn, bump_height: Roll and pitch [rad], height [m] of a robot that should stand
            level at z = 0: standard deviations of a floor that is not quite even.
        slip: Odometry is trusted to this share of the motion at best, and wheels whose grip is
            not known yet may lose this share steadily.
        least_shift, least_turn: … and never more than to this [m], [rad] a step.
        speed, spin: Standard deviation [m/s], [rad/s] about a motion that just goes on.
        longest: A motion is taken to go on for at most this time [s].
    """

    bump_turn: float = float(np.radians(0.3))
    bump_height: float = 0.004
    slip: float = 0.05
    least_shift: float = 0.001
    least_turn: float = float(np.radians(0.05))
    speed: float = 0.3
    spin: float = float(np.radians(25.0))
    longest: float = 1.5


@dataclass(frozen=True, eq=False)
class Belief:
    """A pose with its uncertainty.

    Attributes:
        T_map_camera: The pose.
        covariance: (6, 6) of changes in the optical frame [rad, m].
    """

    T_map_camera: RigidTransform
    covariance: NDArray[np.floating]

    @property
    def sigmas(self) -> tuple[float, float]:
        """Largest standard deviations of the turn [rad] and of the place [m]."""
        return se3.largest_deviations(self.covariance)

    def moved(self, T_old_new: RigidTransform, covariance: NDArray[np.floating]) -> Belief:
        """The belief after a motion that is itself uncertain.

        Args:
            T_old_new: The motion, optical frame.
            covariance: (6, 6) of changes after it.
        """
        carried = se3.moved_covariance(T_old_new.inv(), self.covariance)
        return Belief(composed(self.T_map_camera, T_old_new), carried + covariance)

    def held_to_floor(self, T_base_camera: RigidTransform, settings: MotionSettings) -> Belief:
        """The belief given that the robot stands level at z = 0, up to bumps.

        A Kalman update with roll, pitch and height of the base, which are zero up to `bump_turn`
        and `bump_height`.
        """
        error, H = se3.level_error(self.T_map_camera, T_base_camera)
        noise = np.diag([settings.bump_turn**2, settings.bump_turn**2, settings.bump_height**2])
        gain = self.covariance @ H.T @ np.linalg.inv(H @ self.covariance @ H.T + noise)
        kept = np.eye(6) - gain @ H
        covariance = kept @ self.covariance @ kept.T + gain @ noise @ gain.T
        matrix = self.T_map_camera.as_matrix() @ se3_matrices.exp(-gain @ error)
        return Belief(orthonormal(matrix), covariance)


def agree(before: Belief | None, one: Belief, other: Belief) -> bool:
    """Whether two predictions say the same, up to `CLOSE_SHARE` of the motion since `before`."""
    shift, turn = apart(one, other)
    way, spin = (0.0, 0.0) if before is None else apart(before, one)
    near = shift < max(CLOSE_SHIFT, CLOSE_SHARE * way)
    return near and turn < max(CLOSE_TURN, CLOSE_SHARE * spin)


def apart(one: Belief, other: Belief) -> tuple[float, float]:
    """How far [m] and by how much of a turn [rad] two poses are from each other."""
    shift, turn = distances(one.T_map_camera.as_matrix(), other.T_map_camera.as_matrix())
    return float(shift), float(turn)


def guessed(time: float, settings: MotionSettings, unheld: float = 0.0) -> NDArray[np.float64]:
    """(6, 6) covariance of a motion that nothing told of [rad, m].

    A wrong velocity ε stays wrong: of its variance (ε t)² after a time t without the scene a step d
    adds ε² ((t + d)² - t²), so that fast cameras are no surer than slow ones.

    Args:
        time: For how long [s] it went on.
        settings: How far it may stray.
        unheld: For how long [s] nothing had told of it before.
    """
    since = min(unheld, LONGEST_GUESS)
    until = min(since + time, LONGEST_GUESS)
    return np.diag([settings.spin**2] * 3 + [settings.speed**2] * 3) * (until**2 - since**2)
