"""What `scan` and `demo` write down and tell."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.cli.run_screen import answer_sentences, tell_where, wrapped
from circumspect.errors import CircumspectError
from circumspect.evaluation.scan_error import ScanError, scan_error
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.geometry import Trajectory
from circumspect.recognition import PipelineObserver, RecognitionResult, RecognitionStep
from circumspect.runs import RunFolder
from circumspect.runs.camera_path import camera_path
from circumspect.runs.playback_log import PlaybackLog
from circumspect.runs.run_path_log import RunPathLog
from circumspect.runs.scan_file import ScanFile
from circumspect.simulation import Witness, outlines

if TYPE_CHECKING:
    from circumspect.cli.scan_space import ScanSpace


class ScanReport:
    """Observes a scan on behalf of the command line."""

    def __init__(self, parts: SimulatedScan, path: Path, space: ScanSpace | None = None) -> None:
        """Make the run's folder.

        Args:
            parts: The scan, not yet begun.
            path: The folder.
            space: The ceiling cameras that watch it.

        Raises:
            OutputError: It can not be written.
        """
        self._parts = parts
        self._space = space
        self.folder = RunFolder(path, parts.config)
        self.folder.scan = parts.scan
        truth, walls_xy = partial(_truth, parts.witness), outlines(parts.room.scene)
        self._log = log = RunPathLog(parts.scan, self.folder, truth, walls_xy)
        self._file = ScanFile(parts.scan, path / "scan.json")
        self.playback = PlaybackLog(parts.scan, path, parts.room.scene, parts.witness)
        self.observers: tuple[PipelineObserver, ...] = (
            log, self._file, self.playback, self.folder,
        )  # fmt: skip
        if space is not None:
            from circumspect.cli.scan_space import SpaceLog

            self.observers += (SpaceLog(space, path, lambda: log.odometry),)

    def round_deg(self, step: RecognitionStep) -> float:  # noqa: ARG002 - the scan knows
        """How far round the object the robot is [degrees]."""
        return self._parts.scan.turned_deg

    def tell(self, result: RecognitionResult, as_json: bool, on_the_way: str | None = None) -> None:
        """Measure the scan, write that down too, and print how it ended.

        Args:
            result: Of the run.
            as_json: One JSON line instead of sentences.
            on_the_way: What the object was called after the last frame.
        """
        error = self._error(result)
        seen = self._seen_from_above(result)
        record = self._record(result, error) | seen
        self._file.write({"measured": {**error.summary(), **seen, "missing": list(error.missing)}})
        if as_json:
            print(json.dumps(record))  # noqa: T201
            return
        told = [
            *answer_sentences(result, self.folder.config.get("truth"), on_the_way),
            f"It drove {record['distance_m']:.1f} m; the end: {record['ended']}.",
        ]
        told += [sentence for sentence in (_sentence(error), _space_sentence(seen)) if sentence]
        for sentence in told:
            print(wrapped(sentence))  # noqa: T201
        tell_where(self.folder)

    @property
    def opening(self) -> str:
        """What is going to happen, and how to have it again."""
        config = self.folder.config
        every = 100 * self._parts.scan.settings.speed * self._parts.scan.settings.frame_interval
        return (
            f"{config['object']} from {config['start_deg']:g}°, seed {config['seed']}, "
            f"a frame each {every:g} cm"
        )

    def _error(self, result: RecognitionResult) -> ScanError:
        truth, estimate = _truth(self._parts.witness), camera_path(result)
        if truth is None:
            return ScanError(missing=("no frame was taken",))
        scene, camera = self._parts.room.scene, self._parts.camera
        return scan_error(truth, estimate, self._log.odometry, result.points_xyz, scene, camera)

    def _seen_from_above(self, result: RecognitionResult) -> dict[str, float | None]:
        """What the intelligent space says of the run; nothing where there is none."""
        if self._space is None:
            return {}
        return self._space.measured(camera_path(result), _truth(self._parts.witness))

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


def _truth(witness: Witness) -> Trajectory | None:
    try:
        return witness.trajectory
    except CircumspectError:
        return None  # No frame was taken, so there is nothing to compare.


def _space_sentence(seen: Mapping[str, float | None]) -> str | None:
    """How far it is from what the ceiling cameras say."""
    apart, own = seen.get("ate_space_rmse_m"), seen.get("space_error_m")
    if apart is None or own is None:
        return None
    return (
        f"By the ceiling cameras its path was known within {1e3 * apart:.1f} mm; they know theirs "
        f"within {1e3 * own:.1f} mm."
    )


def _sentence(error: ScanError) -> str | None:
    """How far the scan is from the truth, in words."""
    if error.trajectory is None:
        return None
    told = f"Its path was known within {1e3 * error.trajectory.rmse_m:.0f} mm"
    if error.odometry is not None:
        told += f" (wheels alone: {1e3 * error.odometry.rmse_m:.0f} mm)"
    if error.shape is not None:
        told += f", the surface within {1e3 * error.shape.chamfer_m:.1f} mm"
    return f"{told}."
