"""Notices cameras that were moved since calibration."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

import numpy as np


class CameraWatch:
    """Remembers for each camera how often it contradicted the others lately."""

    def __init__(self, watched: int, fewest: int) -> None:
        """Begin without suspicion.

        Args:
            watched: So many latest comparisons count.
            fewest: So many must contradict, and more than half of those that count.
        """
        self._watched, self._fewest = watched, fewest
        self._apart: dict[str, deque[float]] = {}
        self._disputes: dict[tuple[str, ...], deque[float]] = {}

    def compared(self, agreed: Mapping[str, float], contradicted: Mapping[str, float]) -> None:
        """Take the outcome of one comparison with what was decided.

        Args:
            agreed: Cameras that agree, with the distance from the decision [m].
            contradicted: Those that do not.
        """
        for name in agreed:
            self._apart.setdefault(name, self._empty()).append(0.0)
        for name, apart in contradicted.items():
            self._apart.setdefault(name, self._empty()).append(max(apart, 1e-9))
        for names in [n for n in self._disputes if set(n) <= {*agreed, *contradicted}]:
            del self._disputes[names]

    def disputed(self, cameras: Iterable[str], apart: float) -> None:
        """Take note that cameras contradict each other and no majority decides [m]."""
        names = tuple(sorted(cameras))
        self._disputes.setdefault(names, self._empty()).append(max(apart, 1e-9))

    @property
    def suspects(self) -> frozenset[str]:
        """Cameras one of which moved, nobody knows which."""
        judged = (names for names, apart in self._disputes.items() if self._judged(apart) > 0)
        return frozenset(name for names in judged for name in names)

    @property
    def moved(self) -> dict[str, float]:
        """Cameras that moved, with the median distance from the others [m]."""
        return {name: m for name, apart in self._apart.items() if (m := self._judged(apart)) > 0}

    @property
    def reports(self) -> tuple[str, ...]:
        """A sentence about each suspicion."""
        told = [
            f"camera '{name}' moved since calibration: it is {1e3 * apart:.0f} mm from what the "
            "others say; calibrate its extrinsics again"
            for name, apart in sorted(self.moved.items())
        ]
        for names, apart in sorted(self._disputes.items()):
            if self._judged(apart) > 0:
                which = " or ".join(f"'{name}'" for name in names)
                told.append(
                    f"one of the cameras {which} moved since calibration: they are "
                    f"{1e3 * self._judged(apart):.0f} mm apart and no third one decides; "
                    "calibrate their extrinsics again"
                )
        return tuple(told)

    def _empty(self) -> deque[float]:
        return deque(maxlen=self._watched)

    def _judged(self, apart: deque[float]) -> float:
        """Median distance where a camera contradicts most of the time; 0 where it does not."""
        wrong = [value for value in apart if value > 0]
        if len(wrong) < self._fewest or 2 * len(wrong) <= len(apart):
            return 0.0
        return float(np.median(wrong))
