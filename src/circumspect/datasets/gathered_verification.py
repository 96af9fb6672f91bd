"""Verification that a gathered set is complete and readable."""

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
    """The content of a gathered set.

    Attributes:
        counts: Number of scans with a cloud, by split and class.
        missing: "object from start" of missing scans: requested ones, and starts that other objects
            of the split have.
        without_cloud: Scans without their object.
        foreign: Files that are not in the manifest.
        broken: Path and error of unreadable files.
    """

    counts: dict[tuple[str, str], int]
    missing: tuple[str, ...]
    without_cloud: tuple[str, ...]
    foreign: tuple[str, ...]
    broken: tuple[tuple[str, str], ...]

    @property
    def complete(self) -> bool:
        """Whether nothing is missing or unreadable."""
        return not self.missing and not self.broken and any(self.counts.values())

    def to_dict(self) -> dict[str, Any]:
        """The content in JSON types."""
        return {
            "complete": self.complete,
            "counts": {f"{split}/{name}": n for (split, name), n in sorted(self.counts.items())},
            "missing": list(self.missing),
            "without_cloud": list(self.without_cloud),
            "foreign": list(self.foreign),
            "broken": [{"file": file, "error": error} for file, error in self.broken],
        }


def verify_gathered(
    path: Path, progress: Callable[[int, int], None] | None = None
) -> GatheredVerification:
    """Read a whole set and report what is missing.

    Args:
        path: The folder.
        progress: Called with (done, all) after each scan.

    Raises:
        InputError: The manifest is missing or broken.
    """
    scans = read_manifest(path)
    broken: list[tuple[str, str]] = []
    for done, scan in enumerate(scans, start=1):
        broken += _errors(path, scan)
        if progress:
            progress(done, len(scans))
    broken += [("manifest.jsonl", error) for error in _split_objects(scans)]
    named = {path / name for scan in scans for name in scan.files.values()}
    there = {file for folder in FOLDERS.values() for file in (path / folder).glob("*")}
    with_cloud = [scan for scan in scans if "cloud" in scan.files]
    return GatheredVerification(
        dict(Counter((scan.split, scan.label) for scan in with_cloud)),
        tuple(sorted({*_missing(scans), *_missing_requested(path, scans)})),
        tuple(scan.scan for scan in scans if "cloud" not in scan.files),
        tuple(sorted(str(file.relative_to(path)) for file in there - named)),
        tuple(broken),
    )


def _errors(path: Path, scan: GatheredScan) -> list[tuple[str, str]]:
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
    """Objects with two splits or two classes."""
    known: dict[str, tuple[str, str]] = {}
    errors = []
    for scan in scans:
        if known.setdefault(scan.object, (scan.split, scan.label)) != (scan.split, scan.label):
            errors.append(f"{scan.object} is of two splits or classes")
    return sorted(set(errors))


def _missing_requested(path: Path, scans: list[GatheredScan]) -> list[str]:
    """Requested scans that are missing."""
    asked = read_settings(path).get(ASKED) if (path / SETTINGS).is_file() else None
    if not isinstance(asked, list):
        return []
    there = {scan.scan for scan in scans}
    parts = [str(name).partition("@") for name in asked if name not in there]
    return [f"{object_name} from {_normalised_start(start)}°" for object_name, _, start in parts]


def _normalised_start(start: str) -> str:
    """A start in names, without leading zeros; other texts are unchanged."""
    digits = start.lstrip("0")
    return digits if digits[:1].isdigit() else f"0{digits}"


def _missing(scans: list[GatheredScan]) -> list[str]:
    """Objects that were simulated from some of the starts only; recordings have one start."""
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
