"""A robot with an operator at its side, who may pause it, slow it down, and hinder its camera."""

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
"""Time to the next frame after one was lost [s]."""
MOST_DROPPED = 0.9


class RunStopped(Exception):  # noqa: N818 - no fault, but a wish
    """Raised from `OperatedRobot.observe` when the operator wants the run to end."""


class Operator:
    """What a person wants of a robot; may be told, and asked, from any thread."""

    def __init__(self) -> None:
        """Let the robot run as fast as it can."""
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
        """Whether a hand is before the camera."""
        return self._covered

    @property
    def dropped(self) -> float:
        """Share of the frames that are lost."""
        return self._dropped

    def pause(self) -> None:
        """Hold the next frame back."""
        with self._changed:
            self._paused, self._steps = True, 0

    def resume(self) -> None:
        """Let frames through again."""
        with self._changed:
            self._paused = False
            self._changed.notify_all()

    def step(self) -> None:
        """Let one frame through, and pause."""
        with self._changed:
            self._paused = True
            self._steps = 1
            self._changed.notify_all()

    def stop(self) -> None:
        """End the run."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def cover(self, covered: bool) -> None:
        """Put a hand before the camera, or take it away."""
        self._covered = bool(covered)

    def drop(self, share: float) -> None:
        """Lose a share of the frames.

        Raises:
            InputError: Not from 0 to `MOST_DROPPED`.
        """
        if not 0 <= share <= MOST_DROPPED:
            raise InputError(f"a share of 0 to {MOST_DROPPED} of the frames is lost, not {share}")
        self._dropped = float(share)

    def hurry(self, frames_per_second: float | None) -> None:
        """Let frames through at most so often; None means as fast as they come.

        Raises:
            InputError: Not from 0.1 to 1000.
        """
        if frames_per_second is not None and not 0.1 <= frames_per_second <= 1000:
            raise InputError(f"a pace is from 0.1 to 1000 frames/s, not {frames_per_second}")
        with self._changed:
            self._pace = frames_per_second
            self._changed.notify_all()

    def admit(self, before_waiting: Callable[[], None] | None = None) -> None:
        """Wait until a frame may be taken.

        Args:
            before_waiting: Called once where it can not be taken at once.

        Raises:
            RunStopped: The run is to end.
        """
        with self._changed:
            while not self._stopped and (wait := self._wait()) != 0:
                if before_waiting is not None:
                    before_waiting()
                    before_waiting = None
                self._changed.wait(wait)
            if self._stopped:
                raise RunStopped("stopped by the operator")
            self._steps = 0
            self._last = time.monotonic()

    def _wait(self) -> float | None:
        """How long to wait before asking again [s]; None until something changes."""
        if self._paused:
            return 0 if self._steps else None
        if self._pace is None:
            return 0
        return max(0.0, self._last + 1 / self._pace - time.monotonic())


class OperatedRobot(WrappedRobot):
    """Does what its operator wants; wrap it round whatever else makes the robot."""

    def __init__(self, robot: MobileRobot, operator: Operator, seed: int = 0) -> None:
        """Wrap a robot.

        Args:
            robot: The robot.
            operator: Told by somebody else.
            seed: Says which frames are lost.
        """
        super().__init__(robot)
        self._operator = operator
        self._rng = np.random.default_rng(seed)
        self._held = 0.0

    @property
    def held(self) -> float:
        """See `MobileRobot.held`."""
        return self.robot.held + self._held

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`; waits for the operator, the robot standing still.

        Raises:
            RunStopped: The operator wants the run to end.
        """
        asked = self.now
        self._operator.admit(before_waiting=self.stop)
        while self._rng.random() < self._operator.dropped:
            # Nobody drives on without seeing anything.
            self.stop()
            self.robot.wait(FRAME_PERIOD)
        self._held += self.now - asked
        return super().observe()

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        return frame.covered() if self._operator.covered else frame
