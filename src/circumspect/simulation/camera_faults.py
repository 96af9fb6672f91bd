"""Faults of a robot's camera, for tests and measurements.

Deterministic by seed. Times are seconds of the robot's clock.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circumspect.errors import InputError
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import RgbdFrame

FRAME_PERIOD = 0.5
"""Time to the next frame after one was lost [s]."""


class Blackout(WrappedRobot):
    """For some time no pixel has a depth, and the colour is black."""

    def __init__(self, robot: MobileRobot, after: float, seconds: float = 5.0) -> None:
        super().__init__(robot)
        self._span = (after, after + seconds)

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        return frame.covered() if self._span[0] <= frame.stamp < self._span[1] else frame


class NanFrame(WrappedRobot):
    """One frame, counted from 0, has only NaN depths."""

    def __init__(self, robot: MobileRobot, number: int) -> None:
        super().__init__(robot)
        self._remaining = number

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        self._remaining -= 1
        return frame.covered() if self._remaining == -1 else frame


class WrongUnit(WrappedRobot):
    """From a given time on, the depth is in another unit, such as millimetres."""

    def __init__(self, robot: MobileRobot, after: float = 0.0, factor: float = 1000.0) -> None:
        super().__init__(robot)
        self._after, self._factor = after, factor

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        if frame.stamp < self._after:
            return frame
        return replace(frame, depth=frame.depth * np.float32(self._factor))


class DroppedFrames(WrappedRobot):
    """A fraction of the frames is lost; the robot drives on until the next one."""

    def __init__(
        self, robot: MobileRobot, fraction: float = 0.3, seed: int = 0, period: float = FRAME_PERIOD
    ) -> None:
        super().__init__(robot)
        self._fraction, self._period = _fraction(fraction), period
        self._rng = np.random.default_rng(seed)

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`; time passes for each lost frame."""
        while self._rng.random() < self._fraction:
            self.robot.wait(self._period)
        return super().observe()


class UnorderedFrames(WrappedRobot):
    """A fraction of the frames arrives one frame late, after a newer one."""

    def __init__(
        self, robot: MobileRobot, fraction: float = 0.2, seed: int = 0, period: float = FRAME_PERIOD
    ) -> None:
        super().__init__(robot)
        self._fraction, self._period = _fraction(fraction), period
        self._rng = np.random.default_rng(seed)
        self._delayed: RgbdFrame | None = None

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`; time passes for the frame that overtakes."""
        if self._delayed is not None:
            late, self._delayed = self._delayed, None
            return late
        if self._rng.random() < self._fraction:
            self._delayed = super().observe()
            self.robot.wait(self._period)
        return super().observe()


class EqualStamps(WrappedRobot):
    """A fraction of the frames has the stamp of the previous frame."""

    def __init__(self, robot: MobileRobot, fraction: float = 0.2, seed: int = 0) -> None:
        super().__init__(robot)
        self._fraction = _fraction(fraction)
        self._rng = np.random.default_rng(seed)
        self._last: float | None = None

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        if self._last is not None and self._rng.random() < self._fraction:
            return replace(frame, stamp=self._last)
        self._last = frame.stamp
        return frame


def _fraction(fraction: float) -> float:
    if not 0 <= fraction < 1:
        raise InputError(f"a fraction lies from 0 to below 1, not {fraction}")
    return fraction
