"""How a robot on wheels is told to move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import InputError


@dataclass(frozen=True)
class Velocity:
    """Forward speed and turning rate of `base_link`.

    Attributes:
        forward: [m/s], negative is backward.
        turn: [rad/s], counter-clockwise seen from above.

    Raises:
        InputError: A value is not finite.
    """

    forward: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite([self.forward, self.turn]).all():
            raise InputError(f"a velocity must be finite, not {self.forward}, {self.turn}")

    def clipped(self, max_forward: float, max_turn: float) -> Velocity:
        """The velocity within limits; the arc it follows is kept.

        Args:
            max_forward: Largest speed [m/s], either way.
            max_turn: Largest turning rate [rad/s], either way.
        """
        excess = max(abs(self.forward) / max_forward, abs(self.turn) / max_turn, 1.0)
        return Velocity(self.forward / excess, self.turn / excess)
