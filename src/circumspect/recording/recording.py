"""Base class of recordings."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, MutableMapping
from pathlib import Path

from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.sensing import RgbdFrame


class Recording(ABC):
    """RGB-D frames in order, read on demand.

    Unreadable frames are skipped; `skipped` holds the reasons.
    """

    def __init__(self, path: str | os.PathLike[str], every: int = 1, poses: bool = True) -> None:
        """Store the settings; no file is opened.

        Args:
            path: Path of the recording.
            every: Use every n-th frame only.
            poses: Whether frames carry the recorded poses.

        Raises:
            InputError: `every` is below 1.
        """
        if every < 1:
            raise InputError(f"every {every}: must be at least 1")
        self.path = Path(path)
        self.every, self.poses = every, poses
        self.T_map_world = RigidTransform.identity()
        """Transform from the world frame of the recorded poses to the map frame."""
        self.skipped: MutableMapping[str, str] = {}
        """Skipped items so far, mostly frames, with the reason."""

    @abstractmethod
    def __len__(self) -> int:
        """Number of frames, including broken ones."""

    @abstractmethod
    def __iter__(self) -> Iterator[RgbdFrame]:
        """Read the frames in order.

        Raises:
            InputError: No frame can be read.
        """

    @property
    def has_poses(self) -> bool:
        """False if the recording is known to have no poses before a frame is read."""
        return True

    @property
    def has_floor(self) -> bool:
        """Whether the floor is at z = 0 of the map even without external poses."""
        return False

    @property
    def systematic_disparity(self) -> float | None:
        """Systematic error of the camera's disparity [rad]; None if unknown."""
        return None

    def with_poses(self) -> Iterator[RgbdFrame]:
        """Iterate over the frames with recorded poses; frames without one may be skipped.

        Raises:
            InputError: Poses are required, but no frame has one; see `__iter__` for other errors.
        """
        return iter(self)

    def from_first_pose(self) -> Iterator[RgbdFrame]:
        """Iterate over the frames from the first one whose camera pose is known.

        Folders have a pose from the first frame on, or never; bags may have one later.

        Raises:
            InputError: A bag never has a pose; see `__iter__` for other errors.
        """
        return iter(self)
