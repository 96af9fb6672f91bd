"""Frames and how they lie in each other, as /tf tells."""

from __future__ import annotations

from typing import Any

from scipy.spatial.transform import RigidTransform

from circumspect.recording.pose_messages import transform_of

DEEPEST = 64
"""A chain of more frames is a loop."""


class TransformTree:
    """The latest transform of each frame in its parent."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, RigidTransform]] = {}

    def heard(self, told: Any) -> None:
        """Take a `tf2_msgs/TFMessage` in.

        Raises:
            InputError: A transform is not finite.
        """
        for stamped in told.transforms:
            T = transform_of(stamped.transform.translation, stamped.transform.rotation)
            parent = plain(stamped.header.frame_id)
            self._parents[plain(stamped.child_frame_id)] = (parent, T)

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
