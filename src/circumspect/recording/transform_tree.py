"""Frames and how they lie in each other, as /tf tells."""

from __future__ import annotations

from typing import Any

from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.recording.pose_messages import transform_of

DEEPEST = 64
"""A chain of more frames is a loop."""
MOST = 5000
"""No robot has more frames."""


class TransformTree:
    """The latest transform of each frame in its parent."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, RigidTransform]] = {}

    def heard(self, told: Any) -> None:
        """Take a `tf2_msgs/TFMessage` in.

        Raises:
            InputError: A transform is not finite, or there are more frames than any robot has.
        """
        for stamped in told.transforms:
            T = transform_of(stamped.transform.translation, stamped.transform.rotation)
            parent, child = plain(stamped.header.frame_id), plain(stamped.child_frame_id)
            if len(self._parents) >= MOST and child not in self._parents:
                raise InputError(f"transforms of more than {MOST} frames")
            self._parents[child] = (parent, T)

    @property
    def frames(self) -> set[str]:
        """The names of all of them."""
        return {*self._parents, *(parent for parent, _ in self._parents.values())}

    def between(self, target: str, source: str) -> RigidTransform | None:
        """`T_target_source`; None where nothing links them."""
        up_source, up_target = self._upwards(plain(source)), self._upwards(plain(target))
        for frame, T_frame_source in up_source.items():
            if frame in up_target:
                return up_target[frame].inv() * T_frame_source
        return None

    def _upwards(self, frame: str) -> dict[str, RigidTransform]:
        """T_ancestor_frame of a frame and of all its ancestors, the nearest first."""
        chain = {frame: RigidTransform.identity()}
        while frame in self._parents and len(chain) < DEEPEST:
            parent, T_parent_frame = self._parents[frame]
            if parent in chain:
                break
            # The mount of a camera that hangs directly on the base stays exactly as it was told.
            below = chain[frame]
            chain[parent] = T_parent_frame if len(chain) == 1 else T_parent_frame * below
            frame = parent
        return chain


def plain(frame: str) -> str:
    """The name without the slash that ROS 1 puts before it."""
    return frame.removeprefix("/")
