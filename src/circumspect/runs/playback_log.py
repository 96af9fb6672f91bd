"""Log of a run's moments in its folder, for playback."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.exploration.object_scan import ObjectScan
from circumspect.planning import NextView
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.runs.playback_moment import PlaybackMoment, thinned
from circumspect.runs.run_folder import PLAYBACK
from circumspect.runs.run_path import OdometryPath
from circumspect.runs.surroundings import Surroundings
from circumspect.sensing import RgbdFrame
from circumspect.simulation import GroundTruthRecorder, Scene
from circumspect.storage import atomic_open

MAX_MOMENTS = 96
"""Maximum number of moments; beyond it, every second one is removed and the rate is halved."""
NO_POINTS = np.empty((0, 3))


class PlaybackLog:
    """Writes playback/NUMBER.npz, surroundings and odometry; a `PipelineObserver`.

    A moment takes up to about 100 kB, so that a run of any length takes less than 10 MB.
    """

    def __init__(
        self,
        scan: ObjectScan,
        folder: Path,
        scene: Scene | None = None,
        ground_truth: GroundTruthRecorder | None = None,
    ) -> None:
        """Set what to log; nothing is written yet.

        Args:
            scan: The observed scan.
            folder: Folder of the run.
            scene: The simulated scene, if there is one.
            ground_truth: Recorder of the robot's pose in the scene.
        """
        self._scan, self._scene, self._ground_truth = scan, scene, ground_truth
        self._folder = folder / PLAYBACK
        self._kept: list[int] = []
        self._every = 1
        self._odometry = OdometryPath()
        self.surroundings: Surroundings | None = None

    def on_step(self, step: RecognitionStep) -> None:
        """Write the moment of the step if it is due.

        Raises:
            OutputError: A file cannot be written.
        """
        frame = self._scan.frame
        if frame is None:
            return
        self._begin(step)
        self._odometry.add(step, frame)
        if step.index % self._every:
            return
        self.moment(step, frame).save(self._folder / f"{step.index:06d}.npz")
        self._kept.append(step.index)
        if len(self._kept) > MAX_MOMENTS:
            self._every *= 2
            for number in self._kept:
                if number % self._every:
                    (self._folder / f"{number:06d}.npz").unlink(missing_ok=True)
            self._kept = [number for number in self._kept if number % self._every == 0]

    def on_end(self, result: RecognitionResult) -> None:  # noqa: ARG002 - the steps are enough
        """Write the path by odometry alone.

        Raises:
            OutputError: The file cannot be written.
        """
        if not self._odometry.frames:
            return
        with atomic_open(self._folder / "odometry.npz", "wb") as stream:
            np.savez_compressed(
                stream,
                frames=np.array(self._odometry.frames),
                camera_xyz=np.array(self._odometry.places_xyz),
            )

    def moment(self, step: RecognitionStep, frame: RgbdFrame) -> PlaybackMoment:
        """The moment of a step."""
        points = normals = NO_POINTS
        seen = np.empty(0, np.int64)
        try:
            preview = step.model.preview
            cloud, seen = preview.cloud(), preview.frames_seen()
            points = cloud.points_xyz
            normals = NO_POINTS if cloud.normals_xyz is None else cloud.normals_xyz
        except GeometryError:
            pass  # no points yet
        colour = None if frame.colour is None else thinned(frame.colour)
        target = None if self._scan.target is None else _packed(self._scan.target)
        return PlaybackMoment(
            step.index, points, normals, seen, step.grid, thinned(frame.depth), colour,
            frame.camera, frame.T_base_camera, target,
        )  # fmt: skip

    def _begin(self, step: RecognitionStep) -> None:
        """Write the surroundings at the first pose, which aligns scene and map."""
        if self.surroundings is not None or step.pose is None:
            return
        if self._scene is None or self._ground_truth is None:
            return
        pose = step.pose.T_map_camera
        self.surroundings = Surroundings.with_ground_truth(self._scene, self._ground_truth, pose)
        self.surroundings.save(self._folder / "surroundings.npz")


def _packed(view: NextView) -> NDArray[np.float64]:
    base, normal = view.T_map_base, view.normal_xy
    azimuth = np.nan if normal is None else float(np.arctan2(normal[1], normal[0]))
    return np.array([base.x, base.y, base.yaw, *view.looks_at_xy, azimuth])
