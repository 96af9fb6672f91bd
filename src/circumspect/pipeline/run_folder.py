"""A run on disk."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from circumspect.errors import MissingExtraError
from circumspect.geometry import write_tum
from circumspect.pipeline.camera_path import camera_path
from circumspect.pipeline.journey import Journey
from circumspect.pipeline.records import RecognitionResult, RecognitionStep
from circumspect.pipeline.stage_times import stage_times
from circumspect.storage import append_line, atomic_open, require_no_strangers, write_json

RESULTS = (
    "result.json", "scan.json", "model.ply", "grid.npz", "trajectory.txt", "picture.png",
    "calibration.json", "space.txt", "space.jsonl", "space.png",
)  # fmt: skip
"""Written when a run ends, calibration.json as soon as it has a folder; those of an earlier run are
removed when one begins."""
CONFIG, LOG = "config.json", "log.jsonl"
"""Written when a run begins: what makes a folder that of a run."""
PLAYBACK = "playback"
"""Folder of what `circumspect view` plays back; files of an earlier run are removed, too."""


class RunFolder:
    """Writes down a run while it goes on; a `PipelineObserver`.

    - config.json: what the run was started with
    - log.jsonl: one line a frame
    - result.json: the answer, the reasons of frames that changed nothing, time a stage
    - scan.json: of scans alone: why it ended, what became of the views, errors
    - model.ply: the object's surface
    - grid.npz: its occupancy grid
    - trajectory.txt: where the camera was, TUM format: stamp x y z qx qy qz qw
    - picture.png: all of it at a glance
    - playback/: of scans alone: moments for `circumspect view`, see `PlaybackLog`
    - space.txt, space.jsonl, space.png, calibration.json: of scans with ceiling cameras alone
    """

    def __init__(self, path: str | os.PathLike[str], config: Mapping[str, Any]) -> None:
        """Make the folder and write the config.

        Args:
            path: The folder; made where missing. Files of an earlier run in it are replaced,
                others are left alone.
            config: What the run was started with, JSON types. "truth" and "start_deg", where
                given, appear in the picture.

        Raises:
            OutputError: The folder can not be written, or holds a file that is of no run and
                would be replaced.
        """
        self.path = Path(path)
        names, signs = (CONFIG, LOG, *RESULTS, PLAYBACK), (CONFIG, LOG)
        require_no_strangers(self.path, names, signs)
        self.config = dict(config)
        self.journey = Journey()
        """Where the robot went, for the picture; set by whoever knows before the run ends."""
        self.picture_missing: str | None = None
        """Why there is no picture; None where there is one."""
        write_json(self.path / CONFIG, self.config)
        with atomic_open(self.path / LOG):
            pass
        for name in RESULTS:
            (self.path / name).unlink(missing_ok=True)
        for file in (self.path / PLAYBACK).glob("*.npz"):
            file.unlink(missing_ok=True)

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
        write_json(self.path / "result.json", result_document(result, self.config))
        if (path := camera_path(result)) is not None:
            write_tum(self.path / "trajectory.txt", path)
        last = result.last
        if last is None or last.grid is None:
            self.picture_missing = "there is no object to show"
            return
        last.model.save(self.path / "model.ply")
        last.grid.save(self.path / "grid.npz")
        try:
            from circumspect.pipeline.picture import draw_run

            draw_run(self.path / "picture.png", result, self.config, self.journey)
        except MissingExtraError as error:
            self.picture_missing = str(error)


def result_document(result: RecognitionResult, config: Mapping[str, Any]) -> dict[str, Any]:
    """What a run led to, in JSON types."""
    prediction, last = result.prediction, result.last
    outcomes: dict[str, int] = {}
    for step in result.steps:
        outcomes[step.outcome] = outcomes.get(step.outcome, 0) + 1
    return {
        "label": None if prediction is None else prediction.label,
        "known": None if prediction is None else prediction.known,
        "conclusive": result.conclusive,
        "probability": None if prediction is None else prediction.probability,
        "probabilities": None if prediction is None else dict(prediction.probabilities),
        "truth": config.get("truth"),
        "frames": len(result.steps),
        "outcomes": outcomes,
        "lost_from": result.lost_from,
        "seen": 0.0 if last is None else last.seen,
        "points": 0 if last is None else len(last.model.sums),
        "interrupted": result.interrupted,
        "milliseconds": stage_times(result.steps),
    }
