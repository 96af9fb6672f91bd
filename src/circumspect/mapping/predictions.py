"""Where a camera should be by now: by its wheels, by its motion so far, or where it was."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.motion import Belief, MotionSettings, guessed
from circumspect.mapping.recent_motion import RecentMotion
from circumspect.mapping.wheels import Wheels
from circumspect.sensing import RgbdFrame


class Predictions:
    """What is expected of a frame before it is looked at.

    Attributes:
        wheels: What they tell, and what that is worth.
        recent: The last motion.
    """

    def __init__(self, settings: MotionSettings) -> None:
        """Nothing is known yet.

        Args:
            settings: How far the camera may stray.
        """
        self.wheels, self.recent = Wheels(settings), RecentMotion(settings)
        self._settings = settings
        self._unheld = 0.0

    def passed(self, time: float, held: bool) -> None:
        """A frame was taken in.

        Args:
            time: Since the last one [s].
            held: Whether the scene held the camera in all directions.
        """
        self._unheld = 0.0 if held else self._unheld + max(time, 0.0)

    def by_wheels(self, before: Belief, frame: RgbdFrame) -> Belief | None:
        """What the odometry says, where there is any.

        Args:
            before: The pose at the last frame.
            frame: The next one.
        """
        step = self.wheels.step(frame)
        if step is None or frame.T_base_camera is None:
            return None
        moved = step.by(self.wheels.grip)
        return self._moved(before, frame, moved.T_map_camera, moved.covariance)

    def by_steady_motion(self, before: Belief, frame: RgbdFrame, time: float) -> Belief:
        """As if the last motion went on.

        Args:
            before: The pose at the last frame.
            frame: The next one.
            time: Between both [s].
        """
        return self._moved(before, frame, self.recent.going_on(time), self._strays(time))

    def by_standing_still(self, before: Belief, frame: RgbdFrame, time: float) -> Belief:
        """As if the last motion had ended with the last frame; arguments as before."""
        return self._moved(before, frame, RigidTransform.identity(), self._strays(time))

    def _strays(self, time: float) -> NDArray[np.float64]:
        return guessed(time, self._settings, self._unheld)

    def _moved(
        self,
        before: Belief,
        frame: RgbdFrame,
        T_old_new: RigidTransform,
        covariance: NDArray[np.floating],
    ) -> Belief:
        moved, mount = before.moved(T_old_new, covariance), frame.T_base_camera
        return moved if mount is None else moved.held_to_floor(mount, self._settings)
