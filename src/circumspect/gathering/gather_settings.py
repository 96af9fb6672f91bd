"""Settings of a gathered set."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from circumspect.errors import InputError

if TYPE_CHECKING:
    from circumspect.gathering.object_selection import SelectedObject
    from circumspect.gathering.object_source import Split

CLASSES = ("bed", "chair", "monitor", "sofa", "table", "toilet")
"""Classes from office, bedroom and bathroom, as in the paper's own data."""
TEST_STARTS_DEG = (0.0, 45.0, 90.0, 135.0)
"""The paper's starts [degrees]."""


@dataclass(frozen=True, eq=False)
class ScanTask:
    """A requested scan.

    Attributes:
        object: The scanned object.
        start_deg: Azimuth of the start [degrees].
    """

    object: SelectedObject
    start_deg: float

    @property
    def key(self) -> str:
        """The scan's name."""
        from circumspect.datasets.gathered_set import simulated_name

        return simulated_name(self.object.name, self.start_deg)


@dataclass(frozen=True)
class GatherSettings:
    """A set of scans of objects by a simulated robot.

    Attributes:
        classes: Classes of the objects.
        train_objects: Number of training objects of each class.
        test_objects: Number of test objects of each class; none is a training object.
        train_starts_deg: Azimuths from which each training object is scanned [degrees].
        test_starts_deg: Azimuths from which each test object is scanned [degrees].
        sources: Objects are taken from these sources in turn: furniture (procedural), a folder with
            the layout of ModelNet10, or a mesh pack.
        seed: Random seed of rooms, slip and noise.
        slip: Fraction of the wheels' travel that does not become motion.
        frame_interval: Time between two frames [s].
        frames: Maximum number of frames of a scan.

    Raises:
        InputError: A value is out of range.
    """

    classes: tuple[str, ...] = CLASSES
    train_objects: int = 8
    test_objects: int = 4
    train_starts_deg: tuple[float, ...] = (0.0,)
    test_starts_deg: tuple[float, ...] = TEST_STARTS_DEG
    sources: tuple[str, ...] = ("furniture",)
    seed: int = 0
    slip: float = 0.05
    frame_interval: float = 2.0
    frames: int = 1000

    def __post_init__(self) -> None:
        if not self.classes or not self.sources:
            raise InputError("at least one class and one source are needed")
        if min(self.train_objects, self.test_objects) < 0 or self.frames < 1:
            raise InputError("no number of objects is negative, and a scan has a frame at least")
        if not any(self.counts.values()):
            raise InputError("at least one object and one start are needed")
        for starts in (self.train_starts_deg, self.test_starts_deg):
            _require_starts(starts)
        if not (0 <= self.slip < 1 and 0 < self.frame_interval < 60):
            raise InputError(
                f"slip {self.slip} and frame interval {self.frame_interval} s: give a share below "
                "1 and seconds below 60"
            )

    @property
    def counts(self) -> dict[Split, int]:
        """Split to the number of objects of each class."""
        return {
            "train": self.train_objects if self.train_starts_deg else 0,
            "test": self.test_objects if self.test_starts_deg else 0,
        }

    def tasks(self, objects: Sequence[SelectedObject]) -> list[ScanTask]:
        """All scans: first all objects from the first start, then from the next, …."""
        starts = {"train": self.train_starts_deg, "test": self.test_starts_deg}
        return [
            ScanTask(one, start)
            for start in dict.fromkeys((*self.train_starts_deg, *self.test_starts_deg))
            for one in objects
            if start in starts[one.split]
        ]

    def seed_of(self, task: ScanTask) -> int:
        """The seed of a scan: different for each scan, and reproducible."""
        text = f"{self.seed}/{task.key}".encode()
        return int.from_bytes(hashlib.sha256(text).digest()[:4]) >> 1

    def lasting(self) -> dict[str, object]:
        """Settings that all scans of a folder share, JSON types."""
        return {
            "seed": self.seed, "slip": self.slip, "frame_interval": self.frame_interval,
            "frames": self.frames,
        }  # fmt: skip


def _require_starts(starts: tuple[float, ...]) -> None:
    if not all(0 <= start < 360 for start in starts):
        raise InputError(f"starts {starts}: give degrees from 0 up to 360")
    if len({f"{start:.1f}" for start in set(starts)}) < len(set(starts)):
        raise InputError(f"starts {starts}: give them a tenth of a degree apart")
