"""How a camera moved lately, and where it is if it just goes on."""

from __future__ import annotations

from collections import deque

from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.geometry.composition import composed
from circumspect.mapping.motion import MotionSettings

MOST_SHARE = 2.5
"""A motion is taken to go on for at most so many times as long as it was watched: its error, and
that of the stamps, grows as much. A steady stream that lost one frame still needs the last one
only."""


class RecentMotion:
    """The last steps of a camera, as far back as its velocity needs."""

    def __init__(self, settings: MotionSettings) -> None:
        """Stand still.

        Args:
            settings: How far it may stray.
        """
        self._settings = settings
        self._steps: deque[tuple[RigidTransform, float]] = deque()

    def forget(self) -> None:
        """Nothing is known of the velocity any more."""
        self._steps.clear()

    def add(self, T_old_new: RigidTransform, time: float) -> None:
        """Take one more step.

        Args:
            T_old_new: Camera in its frame before.
            time: What that took [s].
        """
        self._steps.append((T_old_new, time))
        older = sum(taken for _, taken in self._steps) - self._steps[0][1]
        while len(self._steps) > 1 and MOST_SHARE * older >= self._settings.longest:
            self._steps.popleft()
            older -= self._steps[0][1]

    def going_on(self, time: float) -> RigidTransform:
        """Camera in its frame before, if the same motion goes on.

        Frames that were stamped almost at the same time tell no velocity: as many steps are joined
        as are long enough for what is asked.

        Args:
            time: For how long [s] it goes on.
        """
        asked = min(time, self._settings.longest)
        moved, taken = RigidTransform.identity(), 0.0
        for number, (step, step_time) in enumerate(reversed(self._steps)):
            moved, taken = (composed(step, moved) if number else step), taken + step_time
            if MOST_SHARE * taken >= asked:
                break
        share = 0.0 if taken <= 0 else min(asked / taken, MOST_SHARE)
        return se3.exp(share * se3.log(moved))
