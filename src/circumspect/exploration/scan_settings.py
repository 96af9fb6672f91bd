"""How a robot scans an object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import InputError

STUCK_STEP_M, STUCK_TURN_RAD = 0.2, float(np.radians(20.0))
"""Progress is detected well before the robot drives or turns this far."""


@dataclass(frozen=True)
class ScanSettings:
    """How the robot drives, when it looks, and when it gives up.

    Attributes:
        speed: [m/s] (section 3.1).
        frame_interval: Between frames [s] (section 3.1).
        tick: Between two commands to the wheels [s].
        turn_between_frames: The robot turns at most by this from frame to frame [rad].
        keep: Distance to the object that is worth a detour [m]; a camera over the left wheel sees
            nothing of what is nearer than 0.8 m to it.
        patience: Without progress for this long it is blocked, but see `stuck_after` [s].
        back_off: So far it then goes back [m].
        most_blocks: So often it may be blocked before it gives up.
        most_frames: The scan ends after so many frames.
        doubt_after: When no pose was reliable for so long, or for five frames,
            the robot stops and looks round [s].
        blind_after: The same when there was no depth, as beside a wall: the wheels are trusted
            for longer [s].

    Raises:
        InputError: A value makes no sense.
    """

    speed: float = 0.05
    frame_interval: float = 0.5
    tick: float = 0.1
    turn_between_frames: float = float(np.radians(6.0))
    keep: float = 1.1
    patience: float = 4.0
    back_off: float = 0.2
    most_blocks: int = 6
    most_frames: int = 4000
    doubt_after: float = 10.0
    blind_after: float = 60.0

    def __post_init__(self) -> None:
        if not 0.01 <= self.speed <= 1.0:
            raise InputError(f"the speed must be from 0.01 to 1 m/s, not {self.speed}")
        if not 0 < self.tick <= self.frame_interval <= 60:
            raise InputError(
                f"a frame interval is from {self.tick} to 60 s, not {self.frame_interval}"
            )
        if not self.most_frames >= 1:
            raise InputError(f"at least one frame is needed, not {self.most_frames}")
        for name in ("turn_between_frames", "patience", "back_off", "doubt_after", "blind_after"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name} must be positive, not {getattr(self, name)}")
        for name in ("keep", "most_blocks"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} must not be negative, but is {getattr(self, name)}")

    @property
    def max_turn(self) -> float:
        """Largest turning rate [rad/s]."""
        return self.turn_between_frames / self.frame_interval

    @property
    def stuck_after(self) -> float:
        """Without progress for this long the robot is blocked [s]."""
        moving = max(STUCK_STEP_M / self.speed, STUCK_TURN_RAD / self.max_turn)
        return max(self.patience, moving, 2.5 * self.frame_interval)

    @property
    def unsure_after(self) -> float:
        """Without a reliable pose for this long the robot looks round [s]."""
        return max(self.doubt_after, 5 * self.frame_interval)
