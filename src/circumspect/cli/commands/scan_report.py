"""Files and printed report of `scan` and `demo`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.cli.run_screen import answer_sentences, print_folder, wrapped
from circumspect.errors import CircumspectError
from circumspect.evaluation.scan_error import ScanError, scan_error
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.geometry import Trajectory
from circumspect.recognition import PipelineObserver, RecognitionResult, RecognitionStep
from circumspect.runs import RunFolder
from circumspect.runs.playback_log import PlaybackLog
from circumspect.runs.run_path import camera_path
from circumspect.runs.run_path_log import RunPathLog
from circumspect.runs.scan_file import ScanFile
from circumspect.simulation import GroundTruthRecorder, outlines

if TYPE_CHECKING:
    from circumspect.cli.commands.scan_space import ScanSpace


class ScanReport:
    """Observers, files and printed report of a scan."""

    def __init__(self, parts: SimulatedScan, path: Path, space: ScanSpace | None = None) -> None:
        """Make the folder of the run.

        Args:
            parts: The prepared scan.
            path: The folder.
            space: The ceiling cameras; None means none.

        Raises:
            OutputError: It can not be written.
        """
        self._parts = parts
        self._space = space
        self.folder = RunFolder(path, parts.config)
        self.folder.scan = parts.scan
        self.folder.completeness = self._completeness
        self._measured: tuple[RecognitionResult, ScanError] | None = None
        truth, walls_xy = partial(_truth, parts.ground_truth), outlines(parts.room.scene)
        self._log = log = RunPathLog(parts.scan, self.folder, truth, walls_xy)
        self._file = ScanFile(parts.scan, path / "scan.json")
        self.playback = PlaybackLog(parts.scan, path, parts.room.scene, parts.ground_truth)
        self.observers: tuple[PipelineObserver, ...] = (
            log, self._file, self.playback, self.folder,
        )  # fmt: skip
        if space is not None:
            from circumspect.cli.commands.scan_space import SpaceLog

            self.observers += (SpaceLog(space, path, lambda: log.odometry),)

    def round_deg(self, step: RecognitionStep) -> float:  # noqa: ARG002 - the scan knows
        """Angle that the robot has covered round the object [degrees]."""
        return self._parts.scan.turned_deg

    def show(self, result: RecognitionResult, as_json: bool, on_the_way: str | None = None) -> None:
        """Measure the scan, write the measures, and print the result.

        Args:
            result: Result of the run.
            as_json: Print one JSON line instead of sentences.
            on_the_way: Label after the last frame.
        """
        error = self._error(result)
        seen = self._space_measures(result)
        record = self._record(result, error) | seen
        self._file.write({"measured": {**error.summary(), **seen, "missing": list(error.missing)}})
        if as_json:
            print(json.dumps(record))  # noqa: T201
            return
        sentences = [
            *answer_sentences(result, self.folder.config.get("truth"), on_the_way),
            f"It drove {record['distance_m']:.1f} m; the end: {record['ended']}.",
        ]
        sentences += [
            sentence for sentence in (_sentence(error), _space_sentence(seen)) if sentence
        ]
        for sentence in sentences:
            print(wrapped(sentence))  # noqa: T201
        print_folder(self.folder)

    @property
    def opening(self) -> str:
        """Object, start, seed and frame interval of the scan, in one line."""
        config = self.folder.config
        every = 100 * self._parts.scan.settings.speed * self._parts.scan.settings.frame_interval
        return (
            f"{config['object']} from {config['start_deg']:g}°, seed {config['seed']}, "
            f"a frame each {every:g} cm"
        )

    def _error(self, result: RecognitionResult) -> ScanError:
        """The errors of the scan, computed once for picture and report."""
        if self._measured is None or self._measured[0] is not result:
            self._measured = result, self._compared(result)
        return self._measured[1]

    def _completeness(self, result: RecognitionResult) -> dict[str, float]:
        shape = self._error(result).shape
        if shape is None:
            return {}
        return {
            "visible surface modelled": shape.completeness,
            "whole surface modelled": shape.whole_completeness,
        }

    def _compared(self, result: RecognitionResult) -> ScanError:
        truth, estimate = _truth(self._parts.ground_truth), camera_path(result)
        if truth is None:
            return ScanError(missing=("no frame was taken",))
        scene, camera = self._parts.room.scene, self._parts.camera
        return scan_error(truth, estimate, self._log.odometry, result.points_xyz, scene, camera)

    def _space_measures(self, result: RecognitionResult) -> dict[str, float | None]:
        """The measures of the intelligent space; empty without ceiling cameras."""
        if self._space is None:
            return {}
        return self._space.measured(camera_path(result), _truth(self._parts.ground_truth))

    def _record(self, result: RecognitionResult, error: ScanError) -> dict[str, Any]:
        config, measured = self.folder.config, error.summary()
        figures = ("ate_rmse_m", "ate_odometry_rmse_m", "yaw_rmse_deg", "chamfer_m", "completeness")
        return {
            "object": config["object"],
            "true_label": config["true_label"],
            "start_deg": config["start_deg"],
            **self.folder.document(result),
            "distance_m": round(self._parts.scan.driven_m, 3),
            **{name: measured[name] for name in figures},
            "run": str(self.folder.path),
            "ended": self._parts.scan.ended,
        }


def _truth(ground_truth: GroundTruthRecorder) -> Trajectory | None:
    try:
        return ground_truth.trajectory
    except CircumspectError:
        return None  # Without frames there is nothing to compare.


def _space_sentence(seen: Mapping[str, float | None]) -> str | None:
    """The trajectory error against the ceiling cameras, in words."""
    apart, own = seen.get("ate_space_rmse_m"), seen.get("space_error_m")
    if apart is None or own is None:
        return None
    return (
        f"By the ceiling cameras its path was known within {1e3 * apart:.1f} mm; they know theirs "
        f"within {1e3 * own:.1f} mm."
    )


def _sentence(error: ScanError) -> str | None:
    """The errors of the scan against the truth, in words."""
    if error.trajectory is None:
        return None
    text = f"Its path was known within {1e3 * error.trajectory.rmse_m:.0f} mm"
    if error.odometry is not None:
        text += f" (wheels alone: {1e3 * error.odometry.rmse_m:.0f} mm)"
    if error.shape is not None:
        text += f", the surface within {1e3 * error.shape.chamfer_m:.1f} mm"
    return f"{text}."
