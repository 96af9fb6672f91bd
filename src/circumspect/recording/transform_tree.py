"""Tree of coordinate frames from /tf and /tf_static."""

from __future__ import annotations

from collections import deque
from itertools import takewhile
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.recording.pose_interpolation import (
    HISTORY_S,
    MAX_INTERPOLATION_GAP_S,
    MAX_STAMP_DISTANCE_S,
    interpolated,
    is_same_pose,
)
from circumspect.recording.pose_messages import transform_of
from circumspect.recording.ros_time import seconds

MAX_CHAIN_LENGTH = 64
"""Maximum length of a chain of frames; a longer one is a loop."""
MAX_FRAMES = 5000
"""Maximum number of frames."""
MAX_NAME_LENGTH = 1024
"""Maximum length of the name of a frame [characters]."""
MAX_STAMP_REVERSAL_S = 1.0
"""A transform older than the last one by more means that the clock was set back [s]."""
MAX_TRANSFORMS = 2000
"""Maximum number of stored transforms per frame."""


class TransformHistory:
    """Transforms of one frame over time.

    A frame that never moved or is static keeps its transform. The transform of a moving frame is
    valid only for a short time: otherwise a dead localization would still yield poses.

    Attributes:
        parent: Name of the parent frame.
    """

    def __init__(self, parent: str) -> None:
        """Start without transforms."""
        self.parent = parent
        self._entries: deque[tuple[float, RigidTransform]] = deque(maxlen=MAX_TRANSFORMS)
        self._moves = False
        self._static_until = -np.inf

    def add(self, stamp: float, T_parent_child: RigidTransform, static: bool = False) -> None:
        """Add a transform; a late one is ignored.

        Args:
            stamp: Start of its validity [s].
            T_parent_child: The transform.
            static: Whether it is static, as on /tf_static, and valid until replaced.
        """
        entries = self._entries
        if entries and stamp < entries[-1][0] - MAX_STAMP_REVERSAL_S:
            entries.clear()
            self._static_until = -np.inf
        if entries and stamp < entries[-1][0]:
            return
        if entries and stamp == entries[-1][0]:
            entries.pop()
        if entries and not static and not is_same_pose(entries[-1][1], T_parent_child):
            # Two equal transforms show that the frame stood still; a single one may be part of a
            # motion.
            if not self._moves and len(entries) > 1:
                self._static_until = entries[-1][0]
            self._moves = True
        if not self._moves and self._is_repetition(T_parent_child):
            entries.pop()
        entries.append((stamp, T_parent_child))
        # The last two are always kept: they define the interval of the transforms.
        while len(entries) > 2 and entries[0][0] < stamp - HISTORY_S:
            entries.popleft()

    def reset_clock(self) -> None:
        """Change to another clock; a frame that never moved keeps its transform."""
        last = [] if self._moves else [T for _, T in self._entries][-1:]
        self._entries = deque([(-np.inf, T) for T in last], MAX_TRANSFORMS)
        self._static_until = -np.inf

    def is_pending(self, stamp: float) -> bool:
        """Whether the frame moves and its transform at a time [s] is expected soon."""
        entries = self._entries
        if len(entries) < 2 or entries[-1][0] >= stamp:
            return False
        (before, one), (last, other) = entries[-2], entries[-1]
        return last - before <= MAX_INTERPOLATION_GAP_S and not is_same_pose(one, other)

    def at(self, stamp: float) -> RigidTransform | None:
        """`T_parent_child` at a time [s]; None if it is unknown or no longer valid."""
        entries = self._entries
        if not entries:
            return None
        k = next((k for k in reversed(range(len(entries))) if entries[k][0] <= stamp), None)
        if k is None:
            first, T_parent_child = entries[0]
            was_static = not self._moves or first <= self._static_until
            return T_parent_child if was_static or first - stamp <= MAX_STAMP_DISTANCE_S else None
        if not self._moves or stamp <= max(self._static_until, entries[k][0]):
            return entries[k][1]
        return self._pose_while_moving(k, stamp)

    def _pose_while_moving(self, k: int, stamp: float) -> RigidTransform | None:
        """Transform of a moving frame after entry k and before the next one, if any."""
        (before, T_before), validity = self._entries[k], self._validity(k)
        if k + 1 < len(self._entries):
            after, T_after = self._entries[k + 1]
            if after - before <= max(MAX_INTERPOLATION_GAP_S, validity):
                return interpolated(T_before, T_after, (stamp - before) / (after - before))
            if after - stamp <= MAX_STAMP_DISTANCE_S:
                return T_after
        return T_before if stamp - before <= validity else None

    def _validity(self, k: int) -> float:
        """Validity of entry k [s]: frames with rare transforms move slowly."""
        return (
            MAX_STAMP_DISTANCE_S
            if k == 0
            else max(MAX_STAMP_DISTANCE_S, 2 * (self._entries[k][0] - self._entries[k - 1][0]))
        )

    def _is_repetition(self, T: RigidTransform) -> bool:
        """Whether the last two transforms equal T, so that only the last time matters."""
        return len(self._entries) > 1 and all(
            is_same_pose(self._entries[k][1], T) for k in (-2, -1)
        )


class TransformTree:
    """Transforms of all frames over the last seconds."""

    def __init__(self) -> None:
        self._frames: dict[str, TransformHistory] = {}
        self._static: set[str] = set()
        """Frames on /tf_static; /tf does not move them."""

    def add(self, msg: Any, static: bool = False) -> None:
        """Add a `tf2_msgs/TFMessage`.

        Args:
            msg: The message.
            static: Whether its transforms are static, as on /tf_static.

        Raises:
            InputError: A transform is not finite, there are too many frames, or a name is too long.
        """
        for stamped in msg.transforms:
            self._take(stamped, static)

    def _take(self, stamped: Any, static: bool) -> None:
        T = transform_of(stamped.transform.translation, stamped.transform.rotation)
        parent, child = plain(stamped.header.frame_id), plain(stamped.child_frame_id)
        if len(self._frames) >= MAX_FRAMES and child not in self._frames:
            raise InputError(f"transforms of more than {MAX_FRAMES} frames")
        if max(len(parent), len(child)) > MAX_NAME_LENGTH:
            raise InputError(f"a frame's name has more than {MAX_NAME_LENGTH} characters")
        if child in self._static and not static:
            return
        if static:
            self._static.add(child)
        if child not in self._frames or self._frames[child].parent != parent:
            self._frames[child] = TransformHistory(parent)
        self._frames[child].add(seconds(stamped), T, static)

    def add_static(self, stamped: Any) -> None:
        """Add a static transform that is also valid before its stamp.

        Raises:
            InputError: See `add`.
        """
        self._take(stamped, static=True)

    def reset_clock(self) -> None:
        """Change to another clock."""
        for history in self._frames.values():
            history.reset_clock()

    @property
    def frames(self) -> set[str]:
        """Names of all frames."""
        return {*self._frames, *(history.parent for history in self._frames.values())}

    def between(self, target: str, source: str, stamp: float) -> RigidTransform | None:
        """`T_target_source` at a time [s]; None if the frames are not connected then."""
        up_target = self._upwards(plain(target), stamp)
        for frame, T_frame_source in self._upwards(plain(source), stamp).items():
            if frame in up_target:
                return up_target[frame].inv() * T_frame_source
        return None

    def is_pending(self, target: str, source: str, stamp: float) -> bool:
        """Whether source moves below target and its transform at a time [s] is expected soon."""
        below = takewhile(lambda name: name != plain(target), self._upwards(plain(source), stamp))
        return any(self._frames[name].is_pending(stamp) for name in below if name in self._frames)

    def _upwards(self, frame: str, stamp: float) -> dict[str, RigidTransform]:
        """T_ancestor_frame of a frame and its ancestors at a time, nearest first."""
        chain = {frame: RigidTransform.identity()}
        while frame in self._frames and len(chain) < MAX_CHAIN_LENGTH:
            history = self._frames[frame]
            parent = history.parent
            if parent in chain:
                break
            T_parent_frame = history.at(stamp)
            if T_parent_frame is None:
                break
            # The mount of a camera attached directly to the base stays exactly as published.
            below = chain[frame]
            chain[parent] = T_parent_frame if len(chain) == 1 else T_parent_frame * below
            frame = parent
        return chain


def plain(frame: str) -> str:
    """The name without the leading slash of ROS 1."""
    return frame.removeprefix("/")
