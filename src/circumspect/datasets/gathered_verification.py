"""Whether a gathered set is complete and sound."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circumspect.datasets.gathered_set import (
    ASKED,
    FOLDERS,
    SETTINGS,
    GatheredScan,
    read_manifest,
    read_points,
    read_settings,
    simulated_name,
)
from circumspect.errors import CircumspectError
from circumspect.geometry import read_tum
from circumspect.grid import OccupancyGrid


@dataclass(frozen=True)
class GatheredVerification:
    """What a gathered set holds.

    Attributes:
        counts: Split and class to scans with a cloud.
        missing: "object from start" of scans that were asked for, or that other objects of the
            split have.
        without_cloud: Scans that never saw their object.
        foreign: Files that the manifest does not name.
        broken: Path and fault of what can not be read.
    """

    counts: dict[tuple[str, str], int]
    missing: tuple[str, ...]
    without_cloud: tuple[str, ...]
    foreign: tuple[str, ...]
    broken: tuple[tuple[str, str], ...]

    @property
    def complete(self) -> bool:
        """Everything is there and can be read."""
        return not self.missing and not self.broken and any(self.counts.values())

    def to_dict(self) -> dict[str, Any]:
        """JSON types."""
        return {
            "complete": self.complete,
            "counts": {f"{split}/{name}": n for (split, name), n in sorted(self.counts.items())},
            "missing": list(self.missing),
            "without_cloud": list(self.without_cloud),
            "foreign": list(self.foreign),
            "broken": [{"file": file, "fault": fault} for file, fault in self.broken],
        }


def verify_gathered(
    path: Path, progress: Callable[[int, int], None] | None = None
) -> GatheredVerification:
    """Read all of a set and see whether anything is missing.

    Args:
        path: The folder.
        progress: Called with (done, all) after each scan.

    Raises:
        InputError: The manifest is missing or broken.
    """
    scans = read_manifest(path)
    broken: list[tuple[str, str]] = []
    for done, scan in enumerate(scans, start=1):
        broken += _faults(path, scan)
        if progress:
            progress(done, len(scans))
    broken += [("manifest.jsonl", fault) for fault in _split_objects(scans)]
    named = {path / name for scan in scans for name in scan.files.values()}
    there = {file for folder in FOLDERS.values() for file in (path / folder).glob("*")}
    with_cloud = [scan for scan in scans if "cloud" in scan.files]
    return GatheredVerification(
        dict(Counter((scan.split, scan.label) for scan in with_cloud)),
        tuple(sorted({*_missing(scans), *_not_made(path, scans)})),
        tuple(scan.scan for scan in scans if "cloud" not in scan.files),
        tuple(sorted(str(file.relative_to(path)) for file in there - named)),
        tuple(broken),
    )


def _faults(path: Path, scan: GatheredScan) -> list[tuple[str, str]]:
    found = []
    for kind, name in scan.files.items():
        try:
            if kind == "cloud":
                read_points(path / name, scan.scan, 1)
            elif kind == "grid":
                OccupancyGrid.load(path / name)
            else:
                read_tum(path / name)
        except CircumspectError as error:
            found.append((name, str(error)))
    return found


def _split_objects(scans: list[GatheredScan]) -> list[str]:
    """Objects that are of two splits or of two classes."""
    known: dict[str, tuple[str, str]] = {}
    faults = []
    for scan in scans:
        if known.setdefault(scan.object, (scan.split, scan.label)) != (scan.split, scan.label):
            faults.append(f"{scan.object} is of two splits or classes")
    return sorted(set(faults))


def _not_made(path: Path, scans: list[GatheredScan]) -> list[str]:
    """Asked for and not there."""
    asked = read_settings(path).get(ASKED) if (path / SETTINGS).is_file() else None
    if not isinstance(asked, list):
        return []
    there = {scan.scan for scan in scans}
    parts = [str(name).partition("@") for name in asked if name not in there]
    return [f"{thing} from {_as_read(start)}°" for thing, _, start in parts]


def _as_read(start: str) -> str:
    """A start as names have it, without the zeros before it; whatever stands there."""
    digits = start.lstrip("0")
    return digits if digits[:1].isdigit() else f"0{digits}"


def _missing(scans: list[GatheredScan]) -> list[str]:
    """Simulated from some of the starts only; a recording has the start that it has."""
    starts: dict[str, set[float]] = {}
    objects: dict[str, dict[str, set[float]]] = {}
    for scan in scans:
        if scan.start_deg is not None and scan.scan == simulated_name(scan.object, scan.start_deg):
            starts.setdefault(scan.split, set()).add(scan.start_deg)
            there = objects.setdefault(scan.split, {}).setdefault(scan.object, set())
            there.add(scan.start_deg)
    return [
        f"{name} from {start:g}°"
        for split, named in sorted(objects.items())
        for name, there in sorted(named.items())
        for start in sorted(starts[split] - there)
    ]
