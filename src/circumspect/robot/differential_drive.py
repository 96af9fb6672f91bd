"""Kinematics of a differential drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.robot.mobile_robot import Velocity


@dataclass(frozen=True)
class DifferentialDrive:
    """Two driven wheels; `base_link` is on the floor below the centre of their axle.

    The defaults are those of a Pioneer 3-DX.

    Attributes:
        wheel_radius: Radius of the wheels [m].
        track: Distance between the wheels [m].

    Raises:
        InputError: A length is not positive.
    """

    wheel_radius: float = 0.0975
    track: float = 0.33

    def __post_init__(self) -> None:
        if not (0 < self.wheel_radius < np.inf and 0 < self.track < np.inf):
            raise InputError(
                f"wheel radius and track must be positive, not {self.wheel_radius}, {self.track} m"
            )

    def wheel_speeds(self, velocity: Velocity) -> tuple[float, float]:
        """Left and right wheel speed [rad/s]: (v ∓ ω b/2) / r."""
        half = velocity.turn * self.track / 2
        return (
            (velocity.forward - half) / self.wheel_radius,
            (velocity.forward + half) / self.wheel_radius,
        )

    def velocity(self, left: float, right: float) -> Velocity:
        """Velocity from wheel speeds [rad/s]: v = r (ωᵣ + ωₗ) / 2, ω = r (ωᵣ − ωₗ) / b."""
        return Velocity(
            self.wheel_radius * (right + left) / 2,
            self.wheel_radius * (right - left) / self.track,
        )

    def motion(self, left: float, right: float) -> PlanarPose:
        """Motion of the robot while its wheels turn uniformly by given angles [rad].

        Returns:
            `T_before_after`, on the exact arc.
        """
        travel = self.velocity(left, right)
        return arc(travel.forward, travel.turn)


def arc(length: float, turn: float) -> PlanarPose:
    """End of a circular arc that starts at the origin along +x.

    With chord = s sin(Δ/2) / (Δ/2) the end is at (chord cos(Δ/2), chord sin(Δ/2)).

    Args:
        length: Length s of the arc [m].
        turn: Change of heading Δ [rad].
    """
    chord = length * np.sinc(turn / (2 * np.pi))  # np.sinc(x) is sin(πx) / (πx).
    return PlanarPose(chord * np.cos(turn / 2), chord * np.sin(turn / 2), turn)
