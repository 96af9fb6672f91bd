"""The folder of a run."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from circumspect.errors import MissingExtraError, OutputError, reason_of
from circumspect.exploration.view_record import ViewOutcome
from circumspect.folder_lock import lock_folder
from circumspect.geometry import write_tum
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.recognition.recognition_step import answer_record
from circumspect.runs.run_path import RunPath, camera_path
from circumspect.storage import append_line, atomic_open, require_no_foreign_files, write_json

if TYPE_CHECKING:
    from circumspect.exploration.object_scan import ObjectScan

RESULTS = (
    "result.json", "scan.json", "replay.json", "model.ply", "grid.npz", "trajectory.txt",
    "picture.png", "calibration.json", "space.txt", "space.jsonl", "space.png",
)  # fmt: skip
"""Files written at the end of a run, and calibration.json, which is written at its start. Files of
an earlier run are removed at the start."""
CONFIG, LOG = "config.json", "log.jsonl"
"""Files written at the start; they identify the folder of a run."""
PLAYBACK = "playback"
"""Folder that `circumspect view` plays back; files of an earlier run are removed as well."""
PLAN, FRAME = "plan", "frame"


class RunFolder:
    """Writes a run to a folder; a `PipelineObserver`.

    - config.json: the configuration of the run
    - log.jsonl: one line per frame
    - result.json: the answer, the outcomes of the frames, time per stage
    - scan.json: scans only: end reason, outcomes of the views, errors
    - replay.json: replays only: skipped frames, errors against the recorded poses
    - model.ply: the object's surface
    - grid.npz: its occupancy grid
    - trajectory.txt: path of the camera, TUM format: stamp x y z qx qy qz qw
    - picture.png: summary
    - playback/: scans only: moments for `circumspect view`, see `PlaybackLog`
    - space.txt, space.jsonl, space.png, calibration.json: scans with ceiling cameras only
    """

    def __init__(self, path: str | os.PathLike[str], config: Mapping[str, Any]) -> None:
        """Create the folder and write the config.

        Args:
            path: The folder; created if missing. Files of an earlier run are replaced, other files
                are kept.
            config: Configuration of the run, JSON types. "truth" and "start_deg", where
                given, appear in the picture.

        Raises:
            OutputError: Another run writes to the folder, it cannot be written, or it contains a
                foreign file or folder with the name of a run's file.
        """
        self.path = Path(path)
        names, signs = (CONFIG, LOG, *RESULTS, PLAYBACK), (CONFIG, LOG)
        require_no_foreign_files(self.path, names, signs)
        self._lock = lock_folder(self.path)
        earlier = [self.path / name for name in RESULTS]
        earlier += (self.path / PLAYBACK).glob("*.npz")
        _require_no_folders(earlier)
        self.config = dict(config)
        self.run_path = RunPath()
        """The path of the robot, for the picture; set before the run ends."""
        self.scan: ObjectScan | None = None
        """The scan, for planning times and missed views; set before the run starts."""
        self.completeness: Callable[[RecognitionResult], Mapping[str, float]] = lambda _: {}
        """Measures modelled fractions of the true surface, by name, for the picture; empty if the
        true shape is unknown."""
        self.picture_missing: str | None = None
        """Why there is no picture; None if there is one."""
        write_json(self.path / CONFIG, self.config)
        with atomic_open(self.path / LOG):
            pass
        for file in earlier:
            _remove(file)

    def on_step(self, step: RecognitionStep) -> None:
        """Append the step to the log.

        Raises:
            OutputError: The file cannot be written.
        """
        append_line(self.path / LOG, json.dumps(step.summary()))

    def on_end(self, result: RecognitionResult) -> None:
        """Write all other files.

        Raises:
            OutputError: A file cannot be written.
        """
        write_json(self.path / "result.json", self.document(result))
        if (path := camera_path(result)) is not None:
            write_tum(self.path / "trajectory.txt", path)
        last = result.last
        if last is None or last.grid is None:
            self.picture_missing = "there is no object to show"
            return
        last.model.save(self.path / "model.ply")
        last.grid.save(self.path / "grid.npz")
        try:
            from circumspect.runs.picture import draw_run

            picture, missed = self.path / "picture.png", self._why_missed()
            shares = self.completeness(result)
            draw_run(picture, result, self.config, self.run_path, missed, shares)
        except MissingExtraError as error:
            self.picture_missing = str(error)

    def document(self, result: RecognitionResult) -> dict[str, Any]:
        """The contents of result.json, and of `--json` after the run."""
        plan = () if self.scan is None else self.scan.plan_milliseconds
        return result_document(result, self.config, plan)

    def _why_missed(self) -> list[str]:
        views = () if self.scan is None else self.scan.views
        return [record.reason for record in views if record.outcome != ViewOutcome.REACHED]


def _require_no_folders(files: Sequence[Path]) -> None:
    """Check before any file of an earlier run is removed."""
    for file in files:
        if file.is_dir() and not file.is_symlink():
            raise OutputError(
                f"{file}: is a folder where a run has a file; take another folder for the run"
            )


def _remove(file: Path) -> None:
    try:
        file.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(
            f"{file}: can not be removed ({reason_of(error)}); take another folder for the run"
        ) from error


def result_document(
    result: RecognitionResult, config: Mapping[str, Any], plan: Sequence[float] = ()
) -> dict[str, Any]:
    """The result of a run in JSON types.

    Args:
        result: The run.
        config: Configuration of the run; "truth" is copied if given.
        plan: Planning time after each frame [ms].
    """
    return {
        **answer_record(result.prediction),
        "truth": config.get("truth"),
        **result.to_dict(),
        "milliseconds": stage_times(result.steps, plan),
    }


def stage_lists(
    steps: Sequence[RecognitionStep], plan: Sequence[float] = ()
) -> dict[str, list[float]]:
    """Times of each stage [ms], one per frame that reached it; "frame" is the sum of a frame.

    Args:
        steps: The steps of a run.
        plan: Planning time after each frame [ms]; the last frame may have none.
    """
    times: dict[str, list[float]] = {}
    for step, planned in zip_longest(steps, plan):
        stages = dict(step.milliseconds) | ({} if planned is None else {PLAN: planned})
        for name, spent in stages.items():
            times.setdefault(name, []).append(spent)
        if stages:
            times.setdefault(FRAME, []).append(sum(stages.values()))
    return times


def stage_times(
    steps: Sequence[RecognitionStep], plan: Sequence[float] = ()
) -> dict[str, dict[str, float]]:
    """Median and 95th percentile of each stage [ms]; see `stage_lists`."""
    return {
        name: {
            "median": round(float(np.median(spent)), 3),
            "p95": round(float(np.percentile(spent, 95)), 3),
        }
        for name, spent in stage_lists(steps, plan).items()
    }
