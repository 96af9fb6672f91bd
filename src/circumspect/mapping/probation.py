"""When to build again on a camera that had been out of sight, leapt, or fitted oddly."""

from __future__ import annotations

import numpy as np

from circumspect.mapping.attempt import Attempt
from circumspect.mapping.leap import LEAST_DISTANCE
from circumspect.registration import Registration

UNUSUAL, MEMORY, MOST = 3.0, 0.8, 2.0
"""A leap is so many times what frames lay away from where they were expected lately; of which the
mean forgets at this rate a frame, and takes in so many times itself at most. A camera in a hand
leaps all the time, one on wheels does not."""

WHOLE, ODD = 0.95, 3.0
"""A frame of which this share lies on the map lies there oddly where its mean distance to it is so
many times that of such frames lately: it may have slid to a wrong place."""


class Probation:
    """Counts frames that came to lie where they were expected.

    What one frame says to a camera that may be anywhere can be wrong, and what is built on it would
    soon bear it out: the map that the next frames are fitted to would be its own. They are fitted
    to the map as it was until several of them have agreed.

    Attributes:
        left: So many frames must still agree.
    """

    def __init__(self, frames: int, leap: float) -> None:
        """Nothing is on probation yet.

        Args:
            frames: That must agree once the camera was not known well enough to build on.
            leap: After one that was further than this [m] from where it was expected, and unusually
                far, another must agree; turns count by what they move at 1 m.
        """
        self._frames, self._leap = frames, leap
        self._usual = leap
        self._distance = 0.0
        self.left = 0

    def hear(self, attempt: Attempt, known: bool) -> None:
        """Take a frame in.

        Args:
            attempt: What became of it.
            known: Whether the camera was known well enough before it.
        """
        found = attempt.found
        if not known:
            self.left = self._frames
        if attempt.verdict.contradicts or attempt.verdict.mute or found is None:
            return
        away = float(np.linalg.norm(found.innovation.reshape(2, 3), axis=1).max())
        leapt = away > max(self._leap, UNUSUAL * self._usual)
        # Lest two leaps, to a wrong place and back, make a third one usual.
        heard = min(away, MOST * max(self._usual, self._leap / UNUSUAL / MOST))
        self._usual = MEMORY * self._usual + (1 - MEMORY) * heard
        # How a frame lies that leapt says nothing of how frames lie.
        odd = not leapt and self._lies_oddly(found)
        self.left = max(self.left - 1, int(leapt or odd))

    def _lies_oddly(self, found: Registration) -> bool:
        """Take a frame's distance in; whether it lies on the map, but as none did lately."""
        if found.overlap < WHOLE:
            return False  # What is new adds to its distance.
        usual = max(self._distance or found.distance, LEAST_DISTANCE)
        self._distance = MEMORY * usual + (1 - MEMORY) * min(found.distance, MOST * usual)
        return found.distance > ODD * usual
