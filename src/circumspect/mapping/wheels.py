"""What the wheels say between frames and between keyframes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import composed
from circumspect.mapping.motion import MotionSettings, guessed
from circumspect.mapping.wheel_grip import SLACK, WheelGrip
from circumspect.mapping.wheel_motion import WheelMotion, wheel_step
from circumspect.sensing import Odometry, RgbdFrame

MISLED = np.array([0.015, 0.05])
"""Wheels whose step differs by more than this [m], [rad] and half of it spin, jump or are stuck."""
FARTHEST_STEP = 1e2
"""Wheels that tell of more than this [m] from one frame to the next tell nothing: a counter leapt
or a message is broken. After a longer step, with a turn that nobody knows, the covariance can not
be inverted in doubles."""


@dataclass(frozen=True, eq=False)
class Passage:
    """How a camera came from one keyframe to the next.

    Attributes:
        stretch: Changes whenever the scene does not hold a frame.
        by_wheels: The motion since the last keyframe; None where wheels were mute.
        by_scene: (6, 6) information of the scene about where it came to; None where that is
            nothing.
        broken: A frame on the way contradicted its pose, and the next one that fits may have
            leapt to another part of the map; or the robot was carried, and the wheels mislead.
    """

    stretch: int = 0
    by_wheels: WheelMotion | None = None
    by_scene: NDArray[np.floating] | None = None
    broken: bool = False


class Wheels:
    """Listens to the odometry, and learns what it is worth.

    Attributes:
        grip: How much of what the wheels tell becomes motion.
    """

    def __init__(self, settings: MotionSettings) -> None:
        """Nothing is heard yet."""
        self.grip = WheelGrip()
        self._settings = settings
        self._last: Odometry | None = None
        self._mount: RigidTransform | None = None
        self._stamp = 0.0
        self._step: tuple[RgbdFrame, WheelMotion | None] | None = None
        self._misled = False
        self._held = False
        self._unheld = (0.0, 0.0)
        self._stretch = 0
        self._since_key: WheelMotion | None = None
        self._broken = False

    def step(self, frame: RgbdFrame) -> WheelMotion | None:
        """The camera's motion since the last frame heard, where they tell.

        Wheels that misled when the scene last knew better are worth no more than a guess.
        """
        if self._step is None or self._step[0] is not frame:
            self._step = frame, self._stepped(frame)
        return self._step[1]

    def _stepped(self, frame: RgbdFrame) -> WheelMotion | None:
        mounts, before, now = self._mounts(frame), self._last, frame.odometry
        if mounts is None or before is None or now is None or self._told(now) is None:
            return None
        moved = wheel_step(before, now, mounts, self._settings, self._unheld)
        if self._misled:
            return moved.blurred(guessed(frame.stamp - self._stamp, self._settings))
        return moved

    def heard(
        self, frame: RgbdFrame, T_before_now: RigidTransform | None, broken: bool = False
    ) -> None:
        """Take a frame in.

        Args:
            frame: The frame.
            T_before_now: The camera's motion since the last frame; None where the scene does not
                tell it.
            broken: The frame contradicts its pose, or was found elsewhere.
        """
        self._broken |= broken
        step, since = self.step(frame), self._since_key
        self._since_key = None if step is None or since is None else since.then(step)
        if T_before_now is not None and self._held:
            self._learn(frame, T_before_now)
        self._held = T_before_now is not None
        self._stretch += int(not self._held)
        self._unheld = (0.0, 0.0) if self._held else self._further(frame.odometry)
        self._last, self._stamp = frame.odometry, frame.stamp
        self._mount, self._step = frame.T_base_camera, None

    def _mounts(self, frame: RgbdFrame) -> tuple[RigidTransform, RigidTransform] | None:
        """The camera on its robot at the last frame and now; what was not told was as it is."""
        before, now = self._mount, frame.T_base_camera
        return None if now is None else (now if before is None else before, now)

    def _told(self, now: Odometry | None) -> PlanarPose | None:
        """The robot in its frame before, by the wheels; None where they tell nothing."""
        if self._last is None or now is None:
            return None
        told = self._last.T_odom_base.inverse() @ now.T_odom_base
        return told if np.abs(told.xy).max() <= FARTHEST_STEP else None

    def _further(self, now: Odometry | None) -> tuple[float, float]:
        """Way [m] and turn [rad] by the wheels alone, up to now."""
        (way, turn), told = self._unheld, self._told(now)
        if told is None:
            return way, turn
        return way + float(np.hypot(told.x, told.y)), turn + abs(told.yaw)

    def _learn(self, frame: RgbdFrame, T_before_now: RigidTransform) -> None:
        mounts, told = self._mounts(frame), self._told(frame.odometry)
        if mounts is None or told is None:
            return
        found = PlanarPose.from_transform(composed(mounts[0], T_before_now, mounts[1].inv()))
        if self.grip.is_contradicted(told, found, MISLED):
            self._misled = True
        elif (np.abs([found.x, found.yaw]) > SLACK).any():
            # A robot that stands proves nothing of its wheels.
            self._misled = False
        self.grip = self.grip.taught(told, found)

    def at_keyframe(self, by_scene: NDArray[np.floating] | None = None) -> Passage:
        """How the camera came here since the last keyframe; the next passage begins.

        Args:
            by_scene: (6, 6) information of the scene about where it is now.
        """
        told = None if self._broken else by_scene
        passage = Passage(self._stretch, self._since_key, told, self._broken)
        self._since_key = WheelMotion.none()
        self._broken = False
        return passage
