"""One frame in its parent, over the last second."""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy.spatial.transform import RigidTransform

KEPT = 1.0
"""Older transforms are forgotten; one that is older by more belongs to a clock that was set back
[s]."""
LIVELY = 0.2
"""Transforms that follow each other within this [s] tell of something that moves."""


class TransformHistory:
    """What was told of one frame.

    Attributes:
        parent: The frame in which it lies.
    """

    def __init__(self, parent: str) -> None:
        """Begin with nothing told."""
        self.parent = parent
        self._told: deque[tuple[float, RigidTransform]] = deque()

    def heard(self, stamp: float, T_parent_child: RigidTransform) -> None:
        """Take a transform in; one that comes late is left out."""
        told = self._told
        if told and stamp < told[-1][0] - KEPT:
            told.clear()
        if told and stamp < told[-1][0]:
            return
        if told and stamp == told[-1][0]:
            told.pop()
        told.append((stamp, T_parent_child))
        while told[0][0] < stamp - KEPT:
            told.popleft()

    def begin_anew(self) -> None:
        """Keep what was told last, whenever that was: the clock is another one now."""
        _, last = self._told[-1]
        self._told = deque([(-np.inf, last)])

    def awaits(self, stamp: float) -> bool:
        """Whether it moves, and where it is at a time [s] is still to be told."""
        told = self._told
        if len(told) < 2 or told[-1][0] >= stamp:
            return False
        (before, one), (last, other) = told[-2], told[-1]
        return last - before <= LIVELY and not _same(one, other)

    def at(self, stamp: float) -> RigidTransform:
        """`T_parent_child` at a time [s]: between the two told around it, or the nearest one."""
        later = [k for k, (told, _) in enumerate(self._told) if told >= stamp]
        if not later:
            return self._told[-1][1]
        after, T_after = self._told[later[0]]
        if later[0] == 0 or after == stamp:
            return T_after
        before, T_before = self._told[later[0] - 1]
        # What does not move stays exactly as it was told.
        if _same(T_before, T_after):
            return T_before
        share = (stamp - before) / (after - before)
        screw = (T_before.inv() * T_after).as_exp_coords()
        return T_before * RigidTransform.from_exp_coords(share * screw)


def _same(one: RigidTransform, other: RigidTransform) -> bool:
    return np.array_equal(one.as_matrix(), other.as_matrix())
