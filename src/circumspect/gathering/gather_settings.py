"""What is gathered, and how."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Literal

from circumspect.datasets.gathered_set import simulated_name
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES

CLASSES = ("bed", "chair", "monitor", "sofa", "table", "toilet")
"""Of office, bedroom and bathroom, as in the paper's own data."""
FIRST_VARIANT = 200_000
"""Variants of furniture from here on are used by nothing else."""
TEST_EACH = 3
"""Of so many objects of a class the last one is for the test."""


@dataclass(frozen=True)
class ScanTask:
    """One scan to be made.

    Attributes:
        label: Class of the object.
        variant: Which piece of furniture.
        start_deg: Azimuth of the start [degrees].
        split: Of the object.
    """

    label: str
    variant: int
    start_deg: float
    split: Literal["train", "test"]

    @property
    def object(self) -> str:
        """The object's name."""
        return f"{self.label}-{self.variant}"

    @property
    def key(self) -> str:
        """The scan's name."""
        return simulated_name(self.object, self.start_deg)


@dataclass(frozen=True)
class GatherSettings:
    """A set of scans of procedural furniture.

    Attributes:
        classes: Categories of furniture.
        objects: Pieces of each; of every three the third is for the test.
        starts_deg: Azimuths from which each is scanned [degrees].
        seed: Of room, slip and noise of every scan.
        slip: Share of the wheels' travel that does not become motion.
        frame_interval: [s].
        frames: A scan ends after so many.
        only: Objects of this split only; None for all.

    Raises:
        InputError: A value makes no sense.
    """

    classes: tuple[str, ...] = CLASSES
    objects: int = 12
    starts_deg: tuple[float, ...] = tuple(45.0 * number for number in range(8))
    seed: int = 0
    slip: float = 0.05
    frame_interval: float = 2.0
    frames: int = 1000
    only: Literal["train", "test"] | None = None

    def __post_init__(self) -> None:
        unknown = sorted(set(self.classes) - set(CATEGORIES))
        if unknown or not self.classes:
            raise InputError(
                f"no furniture called {', '.join(unknown) or 'nothing'}; there are "
                f"{', '.join(CATEGORIES)}"
            )
        if self.objects < 1 or not self.starts_deg or self.frames < 1:
            raise InputError("at least one object, one start and one frame are needed")
        if not all(0 <= start < 360 for start in self.starts_deg):
            raise InputError(f"starts {self.starts_deg}: give degrees from 0 up to 360")
        names = {simulated_name("", start) for start in set(self.starts_deg)}
        if len(names) < len(set(self.starts_deg)):
            raise InputError(f"starts {self.starts_deg}: give them a tenth of a degree apart")
        if not (0 <= self.slip < 1 and 0 < self.frame_interval < 60):
            raise InputError(
                f"slip {self.slip} and frame interval {self.frame_interval} s: give a share below "
                "1 and seconds below 60"
            )

    @property
    def tasks(self) -> list[ScanTask]:
        """All scans: first all objects from the first start, then from the next, …."""
        return [
            ScanTask(label, FIRST_VARIANT + number, start, _split(number))
            for start in dict.fromkeys(self.starts_deg)
            for number in range(self.objects)
            for label in dict.fromkeys(self.classes)
            if self.only in (None, _split(number))
        ]

    def seed_of(self, task: ScanTask) -> int:
        """The seed of a scan: another one for each, the same at each time."""
        text = f"{self.seed}/{task.key}".encode()
        return int.from_bytes(hashlib.sha256(text).digest()[:4]) >> 1

    def lasting(self) -> dict[str, object]:
        """What all scans of a folder have in common, JSON types."""
        return {
            "seed": self.seed, "slip": self.slip, "frame_interval": self.frame_interval,
            "frames": self.frames,
        }  # fmt: skip


def _split(number: int) -> Literal["train", "test"]:
    return "test" if number % TEST_EACH == TEST_EACH - 1 else "train"
