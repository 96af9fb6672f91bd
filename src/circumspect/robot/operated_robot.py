"""A robot with an operator, who can pause it, slow it down and disturb its camera."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from circumspect.errors import InputError
from circumspect.robot.mobile_robot import MobileRobot
from circumspect.robot.wrapped_robot import WrappedRobot
from circumspect.sensing import RgbdFrame

FRAME_PERIOD = 0.5
"""Time until the next frame after a lost one [s]."""
MAX_DROPPED_FRACTION = 0.9


class RunStopped(Exception):  # noqa: N818 - no fault, but a wish
    """Raised by `OperatedRobot.observe` when the operator stops the run."""


class Operator:
    """Commands of an operator; thread-safe."""

    def __init__(self) -> None:
        """Start without a pause and without a limit of the frame rate."""
        self._changed = threading.Condition()
        self._paused = self._stopped = self._covered = False
        self._steps = 0
        self._dropped = 0.0
        self._pace: float | None = None
        self._last = -np.inf

    @property
    def paused(self) -> bool:
        """Whether frames are held back."""
        return self._paused

    @property
    def covered(self) -> bool:
        """Whether the camera is covered."""
        return self._covered

    @property
    def dropped(self) -> float:
        """Fraction of the frames that are lost."""
        return self._dropped

    def pause(self) -> None:
        """Hold back the next frame."""
        with self._changed:
            self._paused, self._steps = True, 0

    def resume(self) -> None:
        """Release the frames."""
        with self._changed:
            self._paused = False
            self._changed.notify_all()

    def step(self) -> None:
        """Release one frame, and pause again."""
        with self._changed:
            self._paused = True
            self._steps = 1
            self._changed.notify_all()

    def stop(self) -> None:
        """Stop the run."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def cover(self, covered: bool) -> None:
        """Cover or uncover the camera."""
        self._covered = bool(covered)

    def drop(self, fraction: float) -> None:
        """Drop a fraction of the frames.

        Raises:
            InputError: The fraction is not from 0 to `MAX_DROPPED_FRACTION`.
        """
        if not 0 <= fraction <= MAX_DROPPED_FRACTION:
            raise InputError(
                f"the fraction of lost frames must be 0 to {MAX_DROPPED_FRACTION}, not {fraction}"
            )
        self._dropped = float(fraction)

    def set_pace(self, frames_per_second: float | None) -> None:
        """Limit the frame rate; None for no limit.

        Raises:
            InputError: The rate is not from 0.1 to 1000.
        """
        if frames_per_second is not None and not 0.1 <= frames_per_second <= 1000:
            raise InputError(
                f"the pace must be 0.1 to 1000 frames per second, not {frames_per_second}"
            )
        with self._changed:
            self._pace = frames_per_second
            self._changed.notify_all()

    def wait_for_frame(self, on_wait: Callable[[], None] | None = None) -> None:
        """Wait until a frame may be taken.

        Args:
            on_wait: Called once if it cannot be taken immediately.

        Raises:
            RunStopped: The operator stopped the run.
        """
        with self._changed:
            while not self._stopped and (wait := self._remaining_wait()) != 0:
                if on_wait is not None:
                    on_wait()
                    on_wait = None
                self._changed.wait(wait)
            if self._stopped:
                raise RunStopped("stopped by the operator")
            self._steps = 0
            self._last = time.monotonic()

    def _remaining_wait(self) -> float | None:
        """Time until the next check [s]; None until something changes."""
        if self._paused:
            return 0 if self._steps else None
        if self._pace is None:
            return 0
        return max(0.0, self._last + 1 / self._pace - time.monotonic())


class OperatedRobot(WrappedRobot):
    """Follows the commands of its operator; the outermost wrapper of a robot."""

    def __init__(self, robot: MobileRobot, operator: Operator, seed: int = 0) -> None:
        """Wrap a robot.

        Args:
            robot: The robot.
            operator: Its operator.
            seed: Seed that selects lost frames.
        """
        super().__init__(robot)
        self._operator = operator
        self._rng = np.random.default_rng(seed)
        self._paused_seconds = 0.0

    @property
    def paused_seconds(self) -> float:
        """See `MobileRobot.paused_seconds`."""
        return self.robot.paused_seconds + self._paused_seconds

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`; waits for the operator while the robot stands still.

        Raises:
            RunStopped: The operator stopped the run.
        """
        asked = self.now
        self._operator.wait_for_frame(on_wait=self.stop)
        while self._rng.random() < self._operator.dropped:
            # The robot must not drive on without frames.
            self.stop()
            self.robot.wait(FRAME_PERIOD)
        self._paused_seconds += self.now - asked
        return super().observe()

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        return frame.covered() if self._operator.covered else frame
