"""Everything that plays recorded frames."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, MutableMapping
from pathlib import Path

from scipy.spatial.transform import RigidTransform

from circumspect.sensing import RgbdFrame


class Recording(ABC):
    """RGB-D frames in order, read when they are asked for.

    A frame that can not be read is left out and the reason kept in `skipped`.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.T_map_world = RigidTransform.identity()
        """Turns the world frame of the recorded poses into the map frame."""
        self.skipped: MutableMapping[str, str] = {}
        """What was left out so far, mostly names of frames, to the reason why."""

    @abstractmethod
    def __len__(self) -> int:
        """How many frames there are, broken ones included."""

    @abstractmethod
    def __iter__(self) -> Iterator[RgbdFrame]:
        """Read the frames one after the other.

        Raises:
            InputError: Not a single frame can be read.
        """

    def placed(self) -> Iterator[RgbdFrame]:
        """The frames from the first one on that says where the camera is, for registration.

        Folders say it with the first frame, or never; bags may say it later.

        Raises:
            InputError: A bag never says it; see `__iter__` for what else.
        """
        return iter(self)
