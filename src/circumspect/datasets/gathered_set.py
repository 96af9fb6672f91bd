"""Gathered sets: robot scans of labelled objects from several starts.

| file | content |
|---|---|
| settings.json | settings of the gathering |
| manifest.jsonl | one line per scan: object, label, split, start, quality, names of its files |
| clouds/SCAN.npz | points_xyz (n, 3) float32 [m], areas (n,) float32 [m²], in the robot's map |
| grids/SCAN.npz | the occupancy grid, by ray tracing |
| poses/SCAN.txt | estimated path of the camera, TUM format |
| odometry/SCAN.txt | path of the camera by odometry alone, TUM format |
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.storage import atomic_open

MANIFEST, SETTINGS = "manifest.jsonl", "settings.json"
ASKED = "scans"
"""Key of the settings with the names of all requested scans."""
FOLDERS = {"cloud": "clouds", "grid": "grids", "poses": "poses", "odometry": "odometry"}
"""Folders by kind of file."""
POINTS = 4096
"""Points per cloud, drawn by area."""
MAX_BYTES = 512 << 20
"""Maximum size of a cloud's file [bytes]."""
MAX_LINE_BYTES = 1_000_000
"""Largest length of a line in a manifest [bytes]."""


@dataclass(frozen=True)
class GatheredScan:
    """A line of the manifest.

    Attributes:
        scan: Name of the scan, such as chair-200003@045.
        object: Name of the object; all scans of an object are in one split.
        label: Class of the object.
        split: "train" or "test".
        start_deg: Azimuth of the start [degrees]; None if unknown.
        files: Paths of existing files inside the folder, by kind.
        quality: Quality measures of the scan, JSON types.
        source: Source of the object, such as "furniture"; empty if unknown.
    """

    scan: str
    object: str
    label: str
    split: Literal["train", "test"]
    start_deg: float | None
    files: dict[str, str] = field(default_factory=dict)
    quality: dict[str, Any] = field(default_factory=dict)
    source: str = ""

    def line(self) -> str:
        """The line in the manifest."""
        return json.dumps(asdict(self)) + "\n"


def is_gathered(path: Path) -> bool:
    """Whether a folder holds a gathered set."""
    return (path / MANIFEST).is_file()


def read_manifest(path: Path) -> list[GatheredScan]:
    """Read all scans of a folder; a truncated last line is skipped.

    Raises:
        InputError: The manifest cannot be read, or a line is broken.
    """
    file = path / MANIFEST
    try:
        lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: can not be read ({error})") from error
    found: dict[str, GatheredScan] = {}
    for number, line in enumerate(lines, start=1):
        if number == len(lines) and not line.endswith("\n"):
            break
        scan = scan_of_line(line, f"{file}: line {number}")
        found[scan.scan] = scan
    return list(found.values())


def read_settings(path: Path) -> dict[str, Any]:
    """Read the settings of a set.

    Raises:
        InputError: They cannot be read.
    """
    file = path / SETTINGS
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{file}: can not be read ({error})") from error
    if not isinstance(found, dict):
        raise InputError(f"{file}: holds no settings of a gathered set")
    return found


def scan_of_line(line: str, place: str) -> GatheredScan:
    """Read a line of a manifest.

    Args:
        line: A line from `GatheredScan.line`.
        place: Position of the line, for messages.

    Raises:
        InputError: The line is broken.
    """
    try:
        if len(line) > MAX_LINE_BYTES:
            raise ValueError(f"{len(line)} bytes")
        scan = GatheredScan(**json.loads(line))
        texts = (scan.scan, scan.object, scan.label, scan.source)
        named = all(isinstance(text, str) for text in texts)
        files = all(isinstance(name, str) for name in scan.files.values())
        start = scan.start_deg is None or (
            isinstance(scan.start_deg, int | float) and 0 <= scan.start_deg < 360
        )
        known = scan.split in ("train", "test") and set(scan.files) <= set(FOLDERS)
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{place}: is no scan") from error
    if not (named and files and start and known and isinstance(scan.quality, dict)):
        raise InputError(f"{place}: is no scan")
    for name in scan.files.values():
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise InputError(f"{place}: {name} lies outside of the folder")
    return scan


def write_cloud(path: Path, cloud: PointCloud) -> None:
    """Write a cloud with its areas.

    Raises:
        OutputError: The file cannot be written.
    """
    areas = np.ones(len(cloud)) if cloud.areas is None else cloud.areas
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream, points_xyz=cloud.points_xyz.astype(np.float32), areas=areas.astype(np.float32)
        )


def read_points(path: Path, name: str, count: int = POINTS) -> NDArray[np.float32]:
    """Draw points of a cloud by area; the same points for the same name.

    Args:
        path: A file from `write_cloud`.
        name: Name of the scan.
        count: Number of points.

    Returns:
        (count, 3) float32 [m].

    Raises:
        InputError: The file is missing or broken.
    """
    held = read_arrays(path, {"points_xyz": "f", "areas": "f"}, MAX_BYTES)
    try:
        points, areas = held["points_xyz"], held["areas"].astype(np.float64)
        if points.ndim != 2 or points.shape[1:] != (3,) or areas.shape != (len(points),):
            raise ValueError(f"shapes {points.shape} and {areas.shape}")
        if not (len(points) and np.isfinite(points).all() and np.isfinite(areas).all()):
            raise ValueError("empty or not finite")
        if areas.min() < 0 or areas.sum() <= 0:
            raise ValueError("areas")
    except ValueError as error:
        raise InputError(f"{path}: is no cloud of a gathered scan ({error})") from error
    seed = int.from_bytes(hashlib.sha256(name.encode(errors="surrogatepass")).digest()[:8])
    drawn = np.random.default_rng(seed).choice(len(points), count, p=areas / areas.sum())
    return points[np.sort(drawn)].astype(np.float32)


def read_gathered(
    path: Path, split: Literal["train", "test"], starts_deg: Collection[float] | None = None
) -> ObjectSet:
    """Read the scans of a split as labelled clouds, each in the frame of its own robot.

    Args:
        path: The folder.
        split: "train" or "test".
        starts_deg: Use only scans from these starts; None for all.

    Returns:
        Clouds named like the scans, with all classes of the folder.

    Raises:
        InputError: The folder is broken, or has no such scan.
    """
    scans = read_manifest(path)
    chosen = [
        scan
        for scan in scans
        if scan.split == split and (starts_deg is None or scan.start_deg in starts_deg)
    ]
    where = "" if starts_deg is None else f" from {', '.join(f'{s:g}°' for s in starts_deg)}"
    return _clouds_of(path, chosen, scans, f"of the {split} split{where}")


def read_training(path: Path) -> ObjectSet:
    """Read the training scans: those from the first start of each object, as in the paper.

    Recordings with an unknown start are used as well.

    Returns:
        Clouds as from `read_gathered`.

    Raises:
        InputError: The folder is broken, or has no such scan.
    """
    scans = read_manifest(path)
    first: dict[str, float] = {}
    for scan in scans:
        # A scan without its object is useless; the next one is used.
        if scan.start_deg is not None and "cloud" in scan.files:
            first[scan.object] = min(scan.start_deg, first.get(scan.object, math.inf))
    chosen = [
        scan
        for scan in scans
        if scan.split == "train" and scan.start_deg in (None, first.get(scan.object))
    ]
    return _clouds_of(path, chosen, scans, "of the train split")


def _clouds_of(
    path: Path, chosen: Iterable[GatheredScan], scans: Iterable[GatheredScan], what: str
) -> ObjectSet:
    """The clouds of the chosen scans that have one, with all classes of the set."""
    chosen = [scan for scan in chosen if "cloud" in scan.files]
    if not chosen:
        raise InputError(f"{path}: holds no scan {what}")
    classes = tuple(sorted({scan.label for scan in scans}))
    return ObjectSet(
        np.stack([read_points(path / scan.files["cloud"], scan.scan) for scan in chosen]),
        np.array([classes.index(scan.label) for scan in chosen], np.int64),
        np.array([scan.scan for scan in chosen]),
        classes,
        np.array([scan.object for scan in chosen]),
    )


def simulated_name(object_name: str, start_deg: float) -> str:
    """The name of an object's simulated scan; recordings are named after their file."""
    return f"{object_name}@{start_deg:05.1f}".removesuffix(".0")


def scanned_name(scan: str) -> str | None:
    """The name of the object in the name of a simulated or recorded scan.

    Names of objects contain no @, names of recordings may. None if it is not the name of a scan.
    """
    object_name, at, _ = scan.partition("@")
    return object_name if at else None
