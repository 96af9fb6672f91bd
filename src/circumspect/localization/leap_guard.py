"""Tells a pause between images from a clock that leaps once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from circumspect.localization.ceiling_image import CeilingImage

LEAP = 10.0
"""Stamps so far ahead of the latest fix [s] are a leap, unless images are usually so far apart."""
CONFIRMED = 3
"""So many times in a row, each later than the one before, are no leap."""
LAST = 2
"""So many are enough where nothing follows that could tell."""
USUAL = 2.0
"""So many times the usual spacing is not far ahead."""


class LeapGuard:
    """Which stamps to believe: one clock that leaps must not make everything after it late."""

    def __init__(self, cameras: Iterable[str]) -> None:
        """Begin with images that are expected to follow each other closely.

        Args:
            cameras: Names of all.
        """
        self._cameras = frozenset(cameras)
        self._row: list[float] = []
        self._patience = LEAP
        self._followed = False

    def until(self, images: Sequence[CeilingImage], after: float) -> float:
        """The latest stamp that is believed, of these images and of those that leapt before [s].

        Args:
            images: Of one time.
            after: Time of the latest fix [s]; minus infinity before the first.
        """
        limit = self._limit(after)
        newest = max(image.stamp for image in images)
        if newest <= limit:
            self._row = []
            self._followed = self._followed or -np.inf < after < newest
            return limit
        # What comes earlier than a leap before it shows that that one was wrong.
        self._row = [*(stamp for stamp in self._row if stamp < newest), newest]
        if self._agreed(images, limit):
            self._row = []
            return newest
        return self._confirmed(after) if len(self._row) >= CONFIRMED else limit

    def until_the_end(self, after: float) -> float:
        """The same when no more images come.

        Where none ever followed another closely, there is no clock that could have leapt.
        """
        enough = LAST if self._followed else 1
        return self._confirmed(after) if len(self._row) >= enough else self._limit(after)

    def _limit(self, after: float) -> float:
        return after + self._patience if np.isfinite(after) else np.inf

    def _agreed(self, images: Sequence[CeilingImage], limit: float) -> bool:
        """Whether every camera leapt; one alone agrees with nobody."""
        leapt = {image.camera for image in images if image.stamp > limit}
        return len(self._cameras) > 1 and self._cameras <= leapt

    def _confirmed(self, after: float) -> float:
        """Go with the leaps in a row, and with their spacing from now on."""
        newest, spacing = self._row[-1], float(np.median(np.diff([after, *self._row])))
        self._patience = max(LEAP, USUAL * spacing)
        self._row = []
        return newest
