"""Settings of a scan and of its room."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from circumspect.errors import InputError

STUCK_STEP_M, STUCK_TURN_RAD = 0.2, math.radians(20.0)
"""Distance and turn well above the detection limit of progress [m], [rad]."""


@dataclass(frozen=True)
class ScanSettings:
    """Driving, frame intervals and limits of a scan.

    Attributes:
        speed: Driving speed [m/s], 0.01 to 1 (section 3.1).
        frame_interval: Interval between frames [s], 0.1 to 60 (section 3.1).
        tick: Interval between two commands to the wheels [s].
        turn_between_frames: Maximum turn between two frames [rad].
        keep: Distance to the object that is worth a detour [m]; a camera over the left wheel does
            not see anything nearer than 0.8 m.
        patience: Time without progress after which the robot is blocked, see `stuck_after` [s].
        back_off: Distance that a blocked robot drives backwards [m].
        max_blocks: Maximum number of blockages.
        max_frames: Maximum number of frames.
        doubt_after: Time without a reliable pose, at least five frames, after which the robot stops
            and looks round if scans contradict the pose or several poses are possible [s].
        blind_after: The same time for any other reason, such as a view of only the floor or a wall;
            longer, because odometry is used [s].

    Raises:
        InputError: A value is invalid.
    """

    speed: float = 0.05
    frame_interval: float = 0.5
    tick: float = 0.1
    turn_between_frames: float = math.radians(6.0)
    keep: float = 1.1
    patience: float = 4.0
    back_off: float = 0.2
    max_blocks: int = 6
    max_frames: int = 4000
    doubt_after: float = 10.0
    blind_after: float = 60.0

    def __post_init__(self) -> None:
        if not 0.01 <= self.speed <= 1.0:
            raise InputError(f"the speed must be from 0.01 to 1 m/s, not {self.speed}")
        if not 0 < self.tick <= self.frame_interval <= 60:
            raise InputError(
                f"a frame interval is from {self.tick} to 60 s, not {self.frame_interval}"
            )
        if not self.max_frames >= 1:
            raise InputError(f"at least one frame is needed, not {self.max_frames}")
        for name in ("turn_between_frames", "patience", "back_off", "doubt_after", "blind_after"):
            if not 0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} must be positive, not {getattr(self, name)}")
        for name in ("keep", "max_blocks"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} must not be negative, but is {getattr(self, name)}")

    @property
    def max_turn(self) -> float:
        """Largest turning rate [rad/s]."""
        return self.turn_between_frames / self.frame_interval

    @property
    def stuck_after(self) -> float:
        """Time without progress after which the robot is blocked [s]."""
        moving = max(STUCK_STEP_M / self.speed, STUCK_TURN_RAD / self.max_turn)
        return max(self.patience, moving, 2.5 * self.frame_interval)

    @property
    def unsure_after(self) -> float:
        """Time without a reliable pose after which the robot looks round [s]."""
        return max(self.doubt_after, 5 * self.frame_interval)


@dataclass(frozen=True)
class RoomSettings:
    """Settings of the room and of the robot's errors.

    Attributes:
        slip: Fraction of the wheels' travel that does not become motion, 0 to 0.5.
        clutter: Whether the room contains other things.
        mast_height: Height of the camera above the floor [m], 0.05 to 5.
        tilt_deg: Downward tilt of the camera [degrees]; by default the object fits the view.
        wheel_error: Excess of the right wheel's radius over that of the left one, as a fraction
            of their mean, -0.2 to 0.2. The odometry assumes equal wheels.
        bump_height: Height of the highest ridge on the floor [m], 0 to 0.05.
        distorted: Whether the camera's depth is distorted as `DepthNoise` describes.
    """

    slip: float = 0.05
    clutter: bool = field(
        default=True,
        metadata={"off": "Leave the room empty (default: with other furniture)."},
    )
    mast_height: float = 1.2
    tilt_deg: float | None = None
    wheel_error: float = 0.0
    bump_height: float = 0.0
    distorted: bool = False
