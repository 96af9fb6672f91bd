"""The intelligent space that watches a scan: `circumspect scan --space`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from circumspect.errors import CircumspectError, MissingExtraError
from circumspect.evaluation.space_error import error_against_space, path_against_space, space_error
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.geometry import Trajectory, write_tum
from circumspect.localization import CeilingImage, IntelligentSpace, write_calibration
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.recording import RunRecorder
from circumspect.runs.camera_path import camera_path
from circumspect.simulation import (
    CeilingRig,
    CeilingWatch,
    calibrated,
    ceiling_cameras,
    laid_tags,
    outlines,
)

CAMERAS, CEILING = 4, 3.0
"""Under the ceiling [m]."""


class ScanSpace:
    """Ceiling cameras over a simulated scan; the robot hears nothing of them."""

    def __init__(self, parts: SimulatedScan) -> None:
        """Hang cameras, calibrate them by tags on the floor, and begin to watch.

        Args:
            parts: The scan, not yet begun.

        Raises:
            InputError: The room is too large for the cameras.
            MissingExtraError: OpenCV or pupil-apriltags is not installed.
        """
        place, seed = parts.room, int(parts.config["seed"])
        middle = np.array(place.orbit.centre_xy)
        low, high = middle - place.lane_radius, middle + place.lane_radius
        self._parts = parts
        self._rig = CeilingRig(
            ceiling_cameras(low, high, CAMERAS, CEILING, seed=seed), place.scene, seed=seed
        )
        survey, laid = laid_tags(low, high, rng=seed)
        self._calibration = calibrated(self._rig, survey, laid, rng=seed)
        space = IntelligentSpace(self._calibration.cameras, self._rig.mount)
        self._watch = CeilingWatch(self._rig, space)
        parts.witness.others = (*parts.witness.others, self._watch)

    def record(self, recorder: RunRecorder) -> None:
        """Record the cameras' images, too."""
        lenses = {camera.name: camera.lens for camera in self._calibration.cameras}

        def recorded(image: CeilingImage) -> None:
            recorder.ceiling_image(image, lenses[image.camera])

        self._watch.listeners = (*self._watch.listeners, recorded)

    def measured(
        self, estimate: Trajectory | None, truth: Trajectory | None
    ) -> dict[str, float | None]:
        """The run's trajectory error by the intelligent space, and the latter's own.

        Args:
            estimate: The camera's path by the pipeline.
            truth: Its true path, which the simulation knows.

        Returns:
            "ate_space_rmse_m": of the run against the intelligent space, rigidly aligned;
            "space_error_m": what the intelligent space states of itself; "space_true_error_m":
            what the simulation says of that. None where it can not be told.
        """
        track = self._watch.track
        T_base_camera = self._parts.witness.T_base_camera
        told: dict[str, float | None] = {
            "ate_space_rmse_m": None,
            "space_error_m": track.stated_error_m,
            "space_true_error_m": None,
        }
        try:
            if estimate is not None:
                found = error_against_space(estimate, track, T_base_camera)
                told["ate_space_rmse_m"] = found.rmse_m
        except CircumspectError:
            pass  # Too few frames: there is nothing to align.
        if truth is not None and track.known(bridged=False):
            bases = Trajectory(truth.stamps, truth.T_map_camera * T_base_camera.inv())
            told["space_true_error_m"] = space_error(track, bases).position_rmse_m
        return told

    def begin(self, folder: Path) -> None:
        """Write calibration.json: whatever ends the run, its recording can be tracked through.

        Args:
            folder: Of the run.

        Raises:
            OutputError: The file can not be written.
        """
        write_calibration(folder / "calibration.json", self._calibration)

    def save(
        self, folder: Path, estimate: Trajectory | None, odometry: Trajectory | None
    ) -> str | None:
        """Write space.txt, space.jsonl and space.png.

        Args:
            folder: Of the run.
            estimate: The camera's path by the pipeline.
            odometry: The same by the wheels alone.

        Returns:
            Why there is no picture; None where there is one.

        Raises:
            OutputError: A file can not be written.
        """
        track = self._watch.track
        if (trajectory := track.trajectory()) is not None:
            write_tum(folder / "space.txt", trajectory)
        track.write_log(folder / "space.jsonl")
        paths = {"odometry alone": odometry, "path by the pipeline": estimate}
        T_base_camera = self._parts.witness.T_base_camera
        carried = {
            name: moved
            for name, path in paths.items()
            if path is not None
            and (moved := path_against_space(path, track, T_base_camera)) is not None
        }
        surface = next(s for s in self._parts.room.scene.surfaces if s.name == "object")
        try:
            from circumspect.evaluation.space_picture import draw_space

            draw_space(
                folder / "space.png", self._calibration.cameras, self._rig.mount.height, track,
                carried, walls_xy=outlines(self._parts.room.scene),
                object_xy=surface.mesh.vertices_xyz,
            )  # fmt: skip
        except MissingExtraError as error:
            return str(error)
        return None


class SpaceLog:
    """Writes down what the ceiling cameras said of a scan; a `PipelineObserver`."""

    def __init__(
        self, space: ScanSpace, folder: Path, odometry: Callable[[], Trajectory | None]
    ) -> None:
        """Write the calibration.

        Args:
            space: The cameras.
            folder: Of the run, begun.
            odometry: Gives the camera's path by the wheels alone when the run ends.

        Raises:
            OutputError: It can not be written.
        """
        self._space, self._folder, self._odometry = space, folder, odometry
        space.begin(folder)

    def on_step(self, step: RecognitionStep) -> None:
        """Nothing: the cameras keep what they see."""

    def on_end(self, result: RecognitionResult) -> None:
        """Write everything else, however the scan ended.

        Raises:
            OutputError: A file can not be written.
        """
        self._space.save(self._folder, camera_path(result), self._odometry())
