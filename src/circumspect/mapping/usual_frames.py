"""What frames that fit are like, of late."""

from __future__ import annotations

import numpy as np

from circumspect.mapping.leap import LEAST_DISTANCE
from circumspect.registration import Registration

UNUSUAL = 1.5
"""A frame that is this many times further from the map than the last ones, and than
`LEAST_DISTANCE`, may have been fitted from a wrong prediction."""
FADING = 0.99
"""A frame: how soon it is forgotten how many inliers a good frame has."""


class UsualFrames:
    """Running figures of frames that were placed.

    Attributes:
        overlap: Share of a frame that lies on what is known.
        inliers: Of a good frame.
    """

    def __init__(self) -> None:
        """No frame was placed yet."""
        self.overlap = 0.0
        self.inliers = 0.0
        self._distance = np.inf

    @property
    def most_distance(self) -> float:
        """A frame that fits has at most this mean distance to the map [m]."""
        return UNUSUAL * max(self._distance, LEAST_DISTANCE)

    def hear(self, found: Registration) -> None:
        """Take a frame in.

        Args:
            found: Where it was placed.
        """
        self.overlap = 0.5 * (self.overlap + found.overlap)
        before = self._distance if np.isfinite(self._distance) else found.distance
        self._distance = 0.5 * (before + found.distance)
        self.inliers = max(FADING * self.inliers, found.inliers)
