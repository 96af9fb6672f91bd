"""Faults of a robot's camera.

For tests and measurements; deterministic by seed. Times are seconds of the robot's clock.
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
    """For a span of time no pixel has a depth, and the colour is black."""

    def __init__(self, robot: MobileRobot, after: float, seconds: float = 5.0) -> None:
        super().__init__(robot)
        self._span = (after, after + seconds)

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        return frame.covered() if self._span[0] <= frame.stamp < self._span[1] else frame


class NanFrame(WrappedRobot):
    """One frame is all NaN; frames count from 0."""

    def __init__(self, robot: MobileRobot, number: int) -> None:
        super().__init__(robot)
        self._left = number

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        self._left -= 1
        return frame.covered() if self._left == -1 else frame


class WrongUnit(WrappedRobot):
    """From a time on the depth is in another unit: millimetres taken for metres."""

    def __init__(self, robot: MobileRobot, after: float = 0.0, factor: float = 1000.0) -> None:
        super().__init__(robot)
        self._after, self._factor = after, factor

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        if frame.stamp < self._after:
            return frame
        return replace(frame, depth=frame.depth * np.float32(self._factor))


class DroppedFrames(WrappedRobot):
    """A share of the frames is lost: the robot drives on blindly until the next one."""

    def __init__(
        self, robot: MobileRobot, share: float = 0.3, seed: int = 0, period: float = FRAME_PERIOD
    ) -> None:
        super().__init__(robot)
        self._share, self._period = _share(share), period
        self._rng = np.random.default_rng(seed)

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`; lets time pass for each frame lost."""
        while self._rng.random() < self._share:
            self.robot.wait(self._period)
        return super().observe()


class UnorderedFrames(WrappedRobot):
    """A share of the frames comes one too late, after a younger one."""

    def __init__(
        self, robot: MobileRobot, share: float = 0.2, seed: int = 0, period: float = FRAME_PERIOD
    ) -> None:
        super().__init__(robot)
        self._share, self._period = _share(share), period
        self._rng = np.random.default_rng(seed)
        self._held: RgbdFrame | None = None

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`; lets time pass for the frame that overtakes."""
        if self._held is not None:
            late, self._held = self._held, None
            return late
        if self._rng.random() < self._share:
            self._held = super().observe()
            self.robot.wait(self._period)
        return super().observe()


class EqualStamps(WrappedRobot):
    """A share of the frames bears the stamp of the frame before."""

    def __init__(self, robot: MobileRobot, share: float = 0.2, seed: int = 0) -> None:
        super().__init__(robot)
        self._share = _share(share)
        self._rng = np.random.default_rng(seed)
        self._last: float | None = None

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        if self._last is not None and self._rng.random() < self._share:
            return replace(frame, stamp=self._last)
        self._last = frame.stamp
        return frame


def _share(share: float) -> float:
    if not 0 <= share < 1:
        raise InputError(f"a share lies from 0 to below 1, not {share}")
    return share
