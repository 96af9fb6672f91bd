"""A finished run, read from its folder; missing and broken files are reported."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError, InputError, reason_of
from circumspect.geometry import Trajectory, read_cloud, read_tum
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.grid import OccupancyGrid
from circumspect.recognition.recognition_step import ANSWER_KEYS
from circumspect.runs.playback_moment import PlaybackMoment
from circumspect.runs.run_folder import CONFIG, LOG, PLAYBACK
from circumspect.runs.surroundings import Surroundings
from circumspect.viewer.older_keys import with_todays_keys

MOST_FRAMES = 100_000
LARGEST_LOG, LARGEST_JSON, LARGEST_ODOMETRY = 512 << 20, 16 << 20, 16 << 20
"""Maximum sizes of the log, JSON files and odometry [bytes]."""
LARGEST_NUMBER = 1e30
"""Upper bound of numbers; sums of larger ones might overflow."""
LOG_KEYS = ("outcome", "label", "reason", "pose_reason")
ANSWER = (*ANSWER_KEYS, "coverage")
"""Keys of the answer in a row and in the result, which has the final answer."""
Row = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class SavedRun:
    """The contents of a run's folder.

    Attributes:
        path: The folder.
        config: Configuration of the run.
        result: Result of the run; empty if the run was killed.
        rows: One row per frame, see `RecognitionStep.summary`; the last one has the final answer.
        moments: Files of moments by frame number, ascending.
        trajectory: Path of the camera; None if it was not written.
        odometry: Frame numbers, and (n, 3) [m] path of the camera by odometry alone; may be empty.
        surroundings: Walls and clutter.
        points_xyz: (n, 3) [m] points of the final object; may be empty.
        normals_xyz: (n, 3) normals of the points.
        grid: The final grid.
        missing: Sentences about what cannot be shown, and why.
    """

    path: Path
    config: Mapping[str, Any]
    result: Mapping[str, Any]
    rows: Sequence[Row]
    moments: Mapping[int, Path]
    trajectory: Trajectory | None = None
    odometry: tuple[NDArray[np.int64], NDArray[np.float64]] = field(
        default_factory=lambda: (np.empty(0, np.int64), np.empty((0, 3)))
    )
    surroundings: Surroundings = field(default_factory=Surroundings)
    points_xyz: NDArray[np.floating] = field(default_factory=lambda: np.empty((0, 3)))
    normals_xyz: NDArray[np.floating] = field(default_factory=lambda: np.empty((0, 3)))
    grid: OccupancyGrid | None = None
    missing: tuple[str, ...] = ()

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SavedRun:
        """Read a folder that `scan`, `demo` or `replay` wrote.

        Raises:
            InputError: It is not the folder of a run, or its log is broken.
        """
        folder = Path(path)
        if not folder.is_dir():
            raise InputError(f"{folder}: no such folder; give the folder of a run")
        if not (folder / CONFIG).is_file() or not (folder / LOG).is_file():
            raise InputError(
                f"{folder}: not the folder of a run (no {CONFIG} or {LOG}); "
                "circumspect scan, demo and replay make such folders"
            )
        ended = folder / "result.json"
        result = with_todays_keys(_document(ended)) if ended.is_file() else {}
        run = cls(
            folder,
            _document(folder / CONFIG),
            result,
            _ending_with(result, _rows(folder / LOG)),
            _moments(folder / PLAYBACK),
        )
        return _with_optional_files(run)

    def moment(self, frame: int) -> PlaybackMoment | None:
        """The latest moment up to a frame; None if there is none, or if it is broken."""
        kept = [number for number in self.moments if number <= frame]
        return _read_moment(self.moments[kept[-1]]) if kept else None

    def odometry_until(self, frame: int) -> NDArray[np.float64]:
        """(n, 3) [m] the path by odometry alone up to a frame."""
        frames, places = self.odometry
        return places[: int(np.searchsorted(frames, frame, side="right"))]


def _with_optional_files(run: SavedRun) -> SavedRun:
    """Add the optional files of a run."""
    folder, missing = run.path, []
    found: dict[str, Any] = {}

    def take(name: str, file: Path, read: Any, why: str) -> None:
        if not file.is_file():
            missing.append(why)
            return
        try:
            found[name] = read(file)
        except CircumspectError as error:
            missing.append(str(error))

    if not run.moments:
        missing.append(
            "this run kept no moments (it was replayed, or made by an older version): images and "
            "the growing object can not be shown"
        )
    take("trajectory", folder / "trajectory.txt", read_tum, "no poses were written")
    take("cloud", folder / "model.ply", read_cloud, "the final object was not written")
    take("grid", folder / "grid.npz", OccupancyGrid.load, "the final grid was not written")
    if run.moments:
        extra = folder / PLAYBACK
        take("odometry", extra / "odometry.npz", _odometry, "no path by odometry was written")
        take("surroundings", extra / "surroundings.npz", Surroundings.load, "no room is known")
    cloud = found.pop("cloud", None)
    if cloud is not None:
        found["points_xyz"] = cloud.points_xyz
        normals = cloud.normals_xyz
        found["normals_xyz"] = np.zeros_like(cloud.points_xyz) if normals is None else normals
    return replace(run, missing=tuple(missing), **found)


def _document(path: Path) -> Mapping[str, Any]:
    try:
        if path.stat().st_size > LARGEST_JSON:
            raise InputError(f"{path}: larger than {LARGEST_JSON >> 20} MB; not a run's file")
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {reason_of(error)}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: broken JSON; the run can not be shown") from error
    if not isinstance(document, dict):
        raise InputError(f"{path}: broken, an object is expected; the run can not be shown")
    return document


def _rows(path: Path) -> list[Row]:
    """The rows of the log; its last line may be truncated, as by a power failure."""
    if path.stat().st_size > LARGEST_LOG:
        raise InputError(f"{path}: larger than {LARGEST_LOG >> 20} MB; not a run's log")
    rows: list[Row] = []
    with path.open(encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(stream):
            if number >= MOST_FRAMES:
                raise InputError(f"{path}: more than {MOST_FRAMES} frames can not be shown")
            try:
                rows.append(_checked(json.loads(line)))
            except (ValueError, RecursionError, TypeError, KeyError) as error:
                if line.endswith("\n"):
                    raise InputError(f"{path}: line {number + 1} is broken") from error
    return rows


def _ending_with(result: Mapping[str, Any], rows: list[Row]) -> list[Row]:
    """The rows, the last one with the final answer."""
    if rows:
        rows[-1] = _checked({**rows[-1], **{key: result[key] for key in ANSWER if key in result}})
    return rows


def _checked(row: Any) -> Row:
    """A row without its invalid entries."""
    if not isinstance(row, dict):
        raise TypeError("not an object")
    row = with_todays_keys(row)
    if not (_is_number(row["frame"]) and _is_number(row["stamp"])):
        raise TypeError("frame and stamp are no numbers")
    record: dict[str, Any] = {"frame": int(row["frame"]), "stamp": float(row["stamp"])}
    record |= {name: str(row[name])[:300] for name in LOG_KEYS if row.get(name) is not None}
    record |= {
        name: row[name]
        for name in ("probability", "coverage", "points")
        if _is_number(row.get(name))
    }
    flags = ("in_distribution", "confident")
    record |= {name: row[name] for name in flags if isinstance(row.get(name), bool)}
    for name in ("probabilities", "alternatives", "milliseconds"):
        table = row.get(name)
        if isinstance(table, dict):
            record[name] = {
                str(key)[:80]: float(value)
                for key, value in list(table.items())[:1000]
                if _is_number(value)
            }
    place = row.get("camera_xyz")
    if isinstance(place, list) and len(place) == 3 and all(map(_is_number, place)):
        record["camera_xyz"] = [float(value) for value in place]
    return record


def _is_number(value: Any) -> bool:
    """Whether a value is a finite number within bounds."""
    return isinstance(value, int | float) and abs(value) < LARGEST_NUMBER


def _moments(folder: Path) -> dict[int, Path]:
    files = sorted(folder.glob("[0-9]*.npz")) if folder.is_dir() else []
    return {int(file.stem): file for file in files if file.stem.isdecimal()}


def _odometry(path: Path) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    arrays = read_arrays(path, {"frames": "iu", "camera_xyz": "f"}, LARGEST_ODOMETRY)
    frames, places = arrays["frames"], arrays["camera_xyz"]
    if frames.ndim != 1 or places.shape != (len(frames), 3) or not np.isfinite(places).all():
        raise InputError(f"{path}: no path by odometry")
    return frames.astype(np.int64), places.astype(np.float64)


@lru_cache(maxsize=8)
def _read_moment(path: Path) -> PlaybackMoment | None:
    try:
        return PlaybackMoment.load(path)
    except InputError:
        return None
