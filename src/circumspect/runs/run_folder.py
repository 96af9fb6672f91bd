"""A run on disk."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.errors import MissingExtraError, OutputError, reason_of
from circumspect.exploration.view_record import ViewOutcome
from circumspect.folder_lock import lock_folder
from circumspect.geometry import write_tum
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.recognition.recognition_step import answer_record
from circumspect.runs.camera_path import camera_path
from circumspect.runs.run_path import RunPath
from circumspect.runs.stage_times import stage_times
from circumspect.storage import append_line, atomic_open, require_no_strangers, write_json

if TYPE_CHECKING:
    from circumspect.exploration.object_scan import ObjectScan

RESULTS = (
    "result.json", "scan.json", "replay.json", "model.ply", "grid.npz", "trajectory.txt",
    "picture.png", "calibration.json", "space.txt", "space.jsonl", "space.png",
)  # fmt: skip
"""Written when a run ends, calibration.json as soon as it has a folder; those of an earlier run are
removed when one begins."""
CONFIG, LOG = "config.json", "log.jsonl"
"""Written when a run begins: what makes a folder that of a run."""
PLAYBACK = "playback"
"""Folder of what `circumspect view` plays back; files of an earlier run are removed, too."""


class RunFolder:
    """Writes a run to a folder while it runs; a `PipelineObserver`.

    - config.json: the configuration of the run
    - log.jsonl: one line a frame
    - result.json: the answer, the outcomes of the frames, time a stage
    - scan.json: scans only: why it ended, what came of the views, errors
    - replay.json: replays only: skipped frames, errors against the recorded poses
    - model.ply: the object's surface
    - grid.npz: its occupancy grid
    - trajectory.txt: path of the camera, TUM format: stamp x y z qx qy qz qw
    - picture.png: summary
    - playback/: scans only: moments for `circumspect view`, see `PlaybackLog`
    - space.txt, space.jsonl, space.png, calibration.json: scans with ceiling cameras only
    """

    def __init__(self, path: str | os.PathLike[str], config: Mapping[str, Any]) -> None:
        """Make the folder and write the config.

        Args:
            path: The folder; made where missing. Files of an earlier run in it are replaced,
                others are left alone.
            config: What the run was started with, JSON types. "truth" and "start_deg", where
                given, appear in the picture.

        Raises:
            OutputError: Another run writes to the folder, it can not be written, holds a file that
                is of no run and would be replaced, or a folder in the place of a run's file.
        """
        self.path = Path(path)
        names, signs = (CONFIG, LOG, *RESULTS, PLAYBACK), (CONFIG, LOG)
        require_no_strangers(self.path, names, signs)
        self._lock = lock_folder(self.path)
        earlier = [self.path / name for name in RESULTS]
        earlier += (self.path / PLAYBACK).glob("*.npz")
        _require_no_folders(earlier)
        self.config = dict(config)
        self.run_path = RunPath()
        """The path of the robot, for the picture; set before the run ends."""
        self.scan: ObjectScan | None = None
        """The scan, for planning times and missed views; set before the run begins."""
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
            OutputError: The file can not be written.
        """
        append_line(self.path / LOG, json.dumps(step.summary()))

    def on_end(self, result: RecognitionResult) -> None:
        """Write everything else.

        Raises:
            OutputError: A file can not be written.
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
            draw_run(picture, result, self.config, self.run_path, missed)
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
    """Before anything of an earlier run is touched."""
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
        config: "truth" is copied, if given.
        plan: Planning time after each frame [ms].
    """
    last = result.last
    outcomes: dict[str, int] = {}
    for step in result.steps:
        outcomes[step.outcome.value] = outcomes.get(step.outcome.value, 0) + 1
    return {
        **answer_record(result.prediction),
        "truth": config.get("truth"),
        "frames": len(result.steps),
        "outcomes": outcomes,
        "lost_from": result.lost_from,
        "coverage": 0.0 if last is None else last.coverage,
        "points": len(result.points_xyz),
        "interrupted": result.interrupted,
        "end_reason": result.end_reason or None,
        "milliseconds": stage_times(result.steps, plan),
    }
