"""One frame in its parent, over the last seconds."""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.recording.pose_interpolation import APART, KEPT, NEAR, between, same

BACK = 1.0
"""A transform that is older than the last one by more belongs to a clock that was set back [s]."""
MOST = 2000
"""So many transforms of a frame are kept at most."""


class TransformHistory:
    """What was told of one frame.

    One that was never told to lie elsewhere than at first, or that was told for good, stays where
    it is. One that moves is known only for a while after what was told last: else a localization
    that died would still tell where the robot is.

    Attributes:
        parent: The frame in which it lies.
    """

    def __init__(self, parent: str) -> None:
        """Begin with nothing told."""
        self.parent = parent
        self._told: deque[tuple[float, RigidTransform]] = deque(maxlen=MOST)
        self._moves = False
        self._stood_until = -np.inf

    def heard(self, stamp: float, T_parent_child: RigidTransform, lasting: bool = False) -> None:
        """Take a transform in; one that comes late is left out.

        Args:
            stamp: From when it holds [s].
            T_parent_child: The transform.
            lasting: It was told for good, as on /tf_static: it holds until another is told.
        """
        told = self._told
        if told and stamp < told[-1][0] - BACK:
            told.clear()
            self._stood_until = -np.inf
        if told and stamp < told[-1][0]:
            return
        if told and stamp == told[-1][0]:
            told.pop()
        if told and not lasting and not same(told[-1][1], T_parent_child):
            # Told twice alike it stood; told once it may have been on its way.
            if not self._moves and len(told) > 1:
                self._stood_until = told[-1][0]
            self._moves = True
        if not self._moves and self._repeats(T_parent_child):
            told.pop()
        told.append((stamp, T_parent_child))
        # The last two tell how far apart they come, however long that is.
        while len(told) > 2 and told[0][0] < stamp - KEPT:
            told.popleft()

    def begin_anew(self) -> None:
        """Go on with another clock: what does not move is still where it was told to be."""
        last = [] if self._moves else [T for _, T in self._told][-1:]
        self._told = deque([(-np.inf, T) for T in last], MOST)
        self._stood_until = -np.inf

    def awaits(self, stamp: float) -> bool:
        """Whether it moves, and where it is at a time [s] is still to be told soon."""
        told = self._told
        if len(told) < 2 or told[-1][0] >= stamp:
            return False
        (before, one), (last, other) = told[-2], told[-1]
        return last - before <= APART and not same(one, other)

    def at(self, stamp: float) -> RigidTransform | None:
        """`T_parent_child` at a time [s], or None where nothing tells it any more, or yet."""
        told = self._told
        if not told:
            return None
        k = next((k for k in reversed(range(len(told))) if told[k][0] <= stamp), None)
        if k is None:
            first, T_parent_child = told[0]
            stood = not self._moves or first <= self._stood_until
            return T_parent_child if stood or first - stamp <= NEAR else None
        if not self._moves or stamp <= max(self._stood_until, told[k][0]):
            return told[k][1]
        return self._moved(k, stamp)

    def _moved(self, k: int, stamp: float) -> RigidTransform | None:
        """Where that which moves is after what was told k-th, and before the next, if any."""
        (before, T_before), lasts = self._told[k], self._lasts(k)
        if k + 1 < len(self._told):
            after, T_after = self._told[k + 1]
            if after - before <= max(APART, lasts):
                return between(T_before, T_after, (stamp - before) / (after - before))
            if after - stamp <= NEAR:
                return T_after
        return T_before if stamp - before <= lasts else None

    def _lasts(self, k: int) -> float:
        """How long what was told k-th is believed [s]: what is told rarely changes slowly."""
        return NEAR if k == 0 else max(NEAR, 2 * (self._told[k][0] - self._told[k - 1][0]))

    def _repeats(self, T: RigidTransform) -> bool:
        """Whether a transform was told twice already; then only the last time is of use."""
        return len(self._told) > 1 and all(same(self._told[k][1], T) for k in (-2, -1))
