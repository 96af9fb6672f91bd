"""Frames and how they lie in each other, as /tf tells."""

from __future__ import annotations

from itertools import takewhile
from typing import Any

from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.recording.pose_messages import transform_of
from circumspect.recording.ros_time import seconds
from circumspect.recording.transform_history import TransformHistory

DEEPEST = 64
"""A chain of more frames is a loop."""
MOST = 5000
"""No robot has more frames."""
LONGEST_NAME = 1024
"""Of a frame [characters]."""


class TransformTree:
    """The transforms of each frame in its parent over the last seconds."""

    def __init__(self) -> None:
        self._frames: dict[str, TransformHistory] = {}
        self._static: set[str] = set()
        """What /tf_static placed; /tf does not move it."""

    def heard(self, told: Any, lasting: bool = False) -> None:
        """Take a `tf2_msgs/TFMessage` in.

        Args:
            told: The message.
            lasting: It tells of what does not move, as those on /tf_static do.

        Raises:
            InputError: A transform is not finite, there are more frames than any robot has, or
                a name is too long.
        """
        for stamped in told.transforms:
            self._take(stamped, lasting)

    def _take(self, stamped: Any, lasting: bool) -> None:
        T = transform_of(stamped.transform.translation, stamped.transform.rotation)
        parent, child = plain(stamped.header.frame_id), plain(stamped.child_frame_id)
        if len(self._frames) >= MOST and child not in self._frames:
            raise InputError(f"transforms of more than {MOST} frames")
        if max(len(parent), len(child)) > LONGEST_NAME:
            raise InputError(f"a frame's name has more than {LONGEST_NAME} characters")
        if child in self._static and not lasting:
            return
        if lasting:
            self._static.add(child)
        if child not in self._frames or self._frames[child].parent != parent:
            self._frames[child] = TransformHistory(parent)
        self._frames[child].heard(seconds(stamped), T, lasting)

    def hold(self, stamped: Any) -> None:
        """Take in one static transform that holds before its stamp, too.

        Raises:
            InputError: As `heard`.
        """
        self._take(stamped, lasting=True)

    def begin_anew(self) -> None:
        """Go on with another clock."""
        for history in self._frames.values():
            history.begin_anew()

    @property
    def frames(self) -> set[str]:
        """The names of all of them."""
        return {*self._frames, *(history.parent for history in self._frames.values())}

    def between(self, target: str, source: str, stamp: float) -> RigidTransform | None:
        """`T_target_source` at a time [s]; None where nothing links them then."""
        up_target = self._upwards(plain(target), stamp)
        for frame, T_frame_source in self._upwards(plain(source), stamp).items():
            if frame in up_target:
                return up_target[frame].inv() * T_frame_source
        return None

    def awaits(self, target: str, source: str, stamp: float) -> bool:
        """Whether source moves below target, and it is still to be told how at a time [s]."""
        below = takewhile(lambda name: name != plain(target), self._upwards(plain(source), stamp))
        return any(self._frames[name].awaits(stamp) for name in below if name in self._frames)

    def _upwards(self, frame: str, stamp: float) -> dict[str, RigidTransform]:
        """T_ancestor_frame of a frame and of all ancestors known then, the nearest first."""
        chain = {frame: RigidTransform.identity()}
        while frame in self._frames and len(chain) < DEEPEST:
            history = self._frames[frame]
            parent = history.parent
            if parent in chain:
                break
            T_parent_frame = history.at(stamp)
            if T_parent_frame is None:
                break
            # The mount of a camera that hangs directly on the base stays exactly as it was told.
            below = chain[frame]
            chain[parent] = T_parent_frame if len(chain) == 1 else T_parent_frame * below
            frame = parent
        return chain


def plain(frame: str) -> str:
    """The name without the slash that ROS 1 puts before it."""
    return frame.removeprefix("/")
