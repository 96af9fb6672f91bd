"""The robot's own set, as the second half of Table 2 needs it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from circumspect.datasets import ObjectSet
from circumspect.datasets.gathered_set import read_gathered, read_manifest, read_training
from circumspect.errors import InputError
from circumspect.reproduction.published import ANGLES_DEG
from circumspect.training import TrainingSettings
from circumspect.training.held_back import fitted_and_held_back


@dataclass(frozen=True, eq=False)
class RobotScans:
    """Scans that train, and scans of other objects that test.

    Attributes:
        train: Of each object the scan from its first start.
        tests: By the azimuth of the start [degrees], the paper's among them.
        grids: Name of a scan to the file of its grid.
    """

    train: ObjectSet
    tests: dict[float, ObjectSet]
    grids: dict[str, Path]

    @classmethod
    def read(cls, gathered: Path) -> RobotScans:
        """Read a gathered set, and find out before long work whether it will do.

        Args:
            gathered: Folder of a set with the paper's starts, 0°, 45°, 90° and 135°.

        Raises:
            InputError: It can not be read, or lacks a start, a split or scans to hold back.
        """
        scans = read_manifest(gathered)
        starts = sorted({
            scan.start_deg for scan in scans if scan.split == "test" and scan.start_deg is not None
        })  # fmt: skip
        lacking = [f"{start:g}°" for start in ANGLES_DEG if start not in starts]
        if lacking:
            raise InputError(f"{gathered}: holds no test scans from {', '.join(lacking)}")
        train = read_training(gathered)
        try:
            fitted_and_held_back(train, TrainingSettings())
        except InputError as error:
            raise InputError(f"{gathered}: {error}") from error
        tests = {start: read_gathered(gathered, "test", [start]) for start in starts}
        grids = {scan.scan: gathered / scan.files["grid"] for scan in scans if "grid" in scan.files}
        return cls(train, tests, grids)
