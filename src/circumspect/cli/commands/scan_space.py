"""Ceiling cameras that observe a scan: `circumspect scan --space`."""

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
from circumspect.runs.run_path import camera_path
from circumspect.simulation import (
    CeilingRig,
    CeilingTracker,
    calibrated,
    ceiling_cameras,
    outlines,
    surveyed_tags,
)

CAMERAS, CEILING = 4, 3.0
"""Number of cameras, and their height above the floor [m]."""


class ScanSpace:
    """Ceiling cameras over a simulated scan; the robot does not use them."""

    def __init__(self, parts: SimulatedScan) -> None:
        """Place cameras, calibrate them with tags on the floor, and start to track the robot.

        Args:
            parts: The prepared scan.

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
        survey, laid = surveyed_tags(low, high, rng=seed)
        self._calibration = calibrated(self._rig, survey, laid, rng=seed)
        space = IntelligentSpace(self._calibration.cameras, self._rig.mount)
        self._watch = CeilingTracker(self._rig, space)
        parts.ground_truth.observers = (*parts.ground_truth.observers, self._watch)

    def record(self, recorder: RunRecorder) -> None:
        """Also record the images of the cameras."""
        lenses = {camera.name: camera.lens for camera in self._calibration.cameras}

        def recorded(image: CeilingImage) -> None:
            recorder.ceiling_image(image, lenses[image.camera])

        self._watch.listeners = (*self._watch.listeners, recorded)

    def measured(
        self, estimate: Trajectory | None, truth: Trajectory | None
    ) -> dict[str, float | None]:
        """Errors of the run against the intelligent space, and errors of the latter.

        Args:
            estimate: Camera path estimated by the pipeline.
            truth: True camera path of the simulation.

        Returns:
            "ate_space_rmse_m": trajectory error of the run against the intelligent space, rigidly
            aligned; "space_error_m": error stated by the intelligent space; "space_true_error_m":
            its error against the simulation. Each is None if unknown.
        """
        track = self._watch.track
        T_base_camera = self._parts.ground_truth.T_base_camera
        errors: dict[str, float | None] = {
            "ate_space_rmse_m": None,
            "space_error_m": track.stated_error_m,
            "space_true_error_m": None,
        }
        try:
            if estimate is not None:
                found = error_against_space(estimate, track, T_base_camera)
                errors["ate_space_rmse_m"] = found.rmse_m
        except CircumspectError:
            pass  # Too few frames to align.
        if truth is not None and track.known(bridged=False):
            bases = Trajectory(truth.stamps, truth.T_map_camera * T_base_camera.inv())
            errors["space_true_error_m"] = space_error(track, bases).position_rmse_m
        return errors

    def begin(self, folder: Path) -> None:
        """Write calibration.json, with which the recording can be tracked even if the run fails.

        Args:
            folder: Folder of the run.

        Raises:
            OutputError: The file can not be written.
        """
        write_calibration(folder / "calibration.json", self._calibration)

    def save(
        self, folder: Path, estimate: Trajectory | None, odometry: Trajectory | None
    ) -> str | None:
        """Write space.txt, space.jsonl and space.png.

        Args:
            folder: Folder of the run.
            estimate: Camera path estimated by the pipeline.
            odometry: Camera path from wheel odometry alone.

        Returns:
            Why the picture is missing; None if it was drawn.

        Raises:
            OutputError: A file can not be written.
        """
        track = self._watch.track
        if (trajectory := track.trajectory()) is not None:
            write_tum(folder / "space.txt", trajectory)
        track.write_log(folder / "space.jsonl")
        paths = {"odometry alone": odometry, "path by the pipeline": estimate}
        T_base_camera = self._parts.ground_truth.T_base_camera
        moved_mesh = {
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
                moved_mesh, walls_xy=outlines(self._parts.room.scene),
                object_xy=surface.mesh.vertices_xyz,
            )  # fmt: skip
        except MissingExtraError as error:
            return str(error)
        return None


class SpaceLog:
    """Writes the results of the ceiling cameras of a scan; a `PipelineObserver`."""

    def __init__(
        self, space: ScanSpace, folder: Path, odometry: Callable[[], Trajectory | None]
    ) -> None:
        """Write the calibration.

        Args:
            space: The cameras.
            folder: Existing folder of the run.
            odometry: Called at the end of the run; returns the camera path from wheel odometry.

        Raises:
            OutputError: It can not be written.
        """
        self._space, self._folder, self._odometry = space, folder, odometry
        space.begin(folder)

    def on_step(self, step: RecognitionStep) -> None:
        """Do nothing; the cameras store their own results."""

    def on_end(self, result: RecognitionResult) -> None:
        """Write all other files, also after an interrupted scan.

        Raises:
            OutputError: A file can not be written.
        """
        self._space.save(self._folder, camera_path(result), self._odometry())
