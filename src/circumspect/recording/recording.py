"""Everything that plays recorded frames."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, MutableMapping
from enum import Enum
from pathlib import Path

from scipy.spatial.transform import RigidTransform

from circumspect.sensing import RgbdFrame


class GivenPoses(Enum):
    """Which of the recorded poses frames bring along."""

    ALL = "all"
    FIRST = "first"
    """Only that of the first frame: it says where the map lies; the others are to be found."""
    NONE = "none"


class Recording(ABC):
    """RGB-D frames in order, read when they are asked for.

    A frame that can not be read is left out and the reason kept in `skipped`.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.T_map_world = RigidTransform.identity()
        """Turns the world frame of the recorded poses into the map frame."""
        self.skipped: MutableMapping[str, str] = {}
        """Name of a frame to the reason why it was left out, so far."""

    @abstractmethod
    def __len__(self) -> int:
        """How many frames there are, broken ones included."""

    @abstractmethod
    def __iter__(self) -> Iterator[RgbdFrame]:
        """Read the frames one after the other.

        Raises:
            InputError: Not a single frame can be read.
        """
