"""How much of what the wheels tell becomes motion, learnt on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose

DOUBT = np.array([0.3, 0.5])
"""The wheels are believed like after this way [m] and turn [rad] without a fault."""
MEMORY = np.array([4.0, 6.0])
"""What lies back further than this way [m], turn [rad] counts less and less: floors change."""
SLACK, SHARE = np.array([0.01, 0.01]), 0.5
"""A step that differs by more than this [m], [rad] and this share of it teaches nothing."""


@dataclass(frozen=True)
class WheelGrip:
    """Shares of the wheels' way and turn that become motion; 1 is a robot that never slips.

    Told and true ways are added up, so that the errors of single steps cancel, and begin with
    `DOUBT` on both sides.

    Attributes:
        told: (way [m], turn [rad]) by the wheels, as absolute values.
        found: The same by registration; less than none where it went the other way.
    """

    told: tuple[float, float] = (0.0, 0.0)
    found: tuple[float, float] = (0.0, 0.0)

    @property
    def shares(self) -> tuple[float, float]:
        """Of the way and of the turn."""
        way, turn = (np.array(self.found) + DOUBT) / (np.array(self.told) + DOUBT)
        return float(way), float(turn)

    @property
    def novelty(self) -> tuple[float, float]:
        """How little of the way and of the turn was compared so far: 1 is nothing, 0 very much."""
        way, turn = DOUBT / (np.array(self.told) + DOUBT)
        return float(way), float(turn)

    def is_contradicted(
        self, told: PlanarPose, found: PlanarPose, slack: NDArray[np.float64] = SLACK
    ) -> bool:
        """Whether a step differs by more than `SHARE` of it and some slack.

        Args:
            told: Robot in its frame before, by the wheels.
            found: The same by registration.
            slack: (way [m], turn [rad]).
        """
        wheels, true = np.array([told.x, told.yaw]), np.array([found.x, found.yaw])
        expected = np.array(self.shares) * wheels
        return bool((np.abs(true - expected) > slack + SHARE * np.abs(wheels)).any())

    def taught(self, told: PlanarPose, found: PlanarPose) -> WheelGrip:
        """What is known after one more step.

        Args:
            told: Robot in its frame before, by the wheels.
            found: The same by registration.
        """
        if self.is_contradicted(told, found):
            return self
        wheels, true = np.array([told.x, told.yaw]), np.array([found.x, found.yaw])
        step = np.abs(wheels)
        kept = np.exp(-step / MEMORY)
        told_sums = kept * self.told + step
        found_sums = kept * self.found + true * np.sign(wheels)
        return WheelGrip(
            (float(told_sums[0]), float(told_sums[1])), (float(found_sums[0]), float(found_sums[1]))
        )
