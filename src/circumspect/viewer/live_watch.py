"""Observer that shows a live run in a dashboard without delaying the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import GeometryError
from circumspect.grid import OccupancyGrid
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.runs import PlannedView
from circumspect.runs.run_path import OdometryPath
from circumspect.runs.surroundings import Surroundings
from circumspect.sensing import RgbdFrame
from circumspect.simulation import GroundTruthRecorder, Scene
from circumspect.viewer.dashboard import Dashboard
from circumspect.viewer.dashboard_state import NOTHING, DashboardState, FrameImages, ObjectSnapshot

_Moment = tuple[RecognitionStep, RgbdFrame | None, PlannedView | None, ObjectModel]

MOST_FRAMES = 20_000
"""Maximum number of stored frames, more than an hour at 5 Hz; then the older half is dropped."""


class Watchable(Protocol):
    """A run that can be watched: an `ObjectScan`, `OperatedFrames`, a node."""

    @property
    def frame(self) -> RgbdFrame | None:
        """The current frame."""
        ...

    @property
    def target(self) -> PlannedView | None:
        """The next view of the robot."""
        ...

    @property
    def ended(self) -> str | None:
        """Why the run ended; None while it runs."""
        ...


class LiveWatch:
    """Passes the newest state to the dashboard's thread; a `PipelineObserver`.

    The run's thread only stores references and a few numbers; the dashboard's thread makes points,
    colours and pictures.

    Attributes:
        message: A line about the whole run, shown until it ends.
    """

    def __init__(
        self,
        run: Watchable,
        dashboard: Dashboard,
        scene: Scene | None = None,
        ground_truth: GroundTruthRecorder | None = None,
        truth: str | None = None,
    ) -> None:
        """Watch a run.

        Args:
            run: The run, before its start.
            dashboard: The dashboard that shows the run.
            scene: The simulated scene, if there is one.
            ground_truth: Recorder that aligns the scene with the robot's map.
            truth: True class of the object, if known.
        """
        self.message = ""
        self._run, self._dashboard = run, dashboard
        self._scene, self._ground_truth, self._truth = scene, ground_truth, truth
        self._rows: list[Mapping[str, Any]] = []
        self._path: list[NDArray[np.float64]] = []
        self._odometry = OdometryPath()
        self._surroundings: Surroundings | None = None
        self._last: _Moment | None = None

    def on_step(self, step: RecognitionStep) -> None:
        """Pass the step to the dashboard."""
        frame, target = self._run.frame, self._run.target
        self._rows.append(step.summary())
        if step.pose is not None:
            self._set_surroundings(step.pose.T_map_camera)
            self._path.append(step.pose.T_map_camera.translation)
        self._odometry.add(step, frame)
        self._drop_old_frames()
        # The full model of a large object would delay the run.
        self._last = (step, frame, target, step.model.preview)
        self._put(self.message)

    def show_message(self, message: str) -> None:
        """Show a line about the run until it ends; may be called from any thread."""
        self.message = message
        if self._last is None:
            self._dashboard.put(lambda: DashboardState((), 0, message=message, run=self))
        else:
            self._put(message)

    def settled(self, prediction: Prediction) -> None:
        """Show the final answer after the last frame so far.

        Args:
            prediction: The answer over all grids.
        """
        if self._last is None:
            return
        step, frame, target, model = self._last
        coverage = step.coverage if prediction.coverage is None else prediction.coverage
        step = replace(step, prediction=prediction, coverage=coverage)
        self._last = (step, frame, target, model)
        self._rows = [*self._rows[:-1], step.summary()]
        self._put(self.message)

    def on_end(self, result: RecognitionResult) -> None:
        """Show the end of the run with the final corrections."""
        if self._last is None or result.last is None:
            return
        _, frame, target, _ = self._last
        self._path = [s.pose.T_map_camera.translation for s in result.steps if s.pose is not None]
        self._last = (result.last, frame, target, result.last.model)
        if self._rows:
            self._rows[-1] = result.last.summary()
        early = result.end_reason or "interrupted" if result.interrupted else ""
        self._put(f"the run is over: {self._run.ended or early or 'no more frames'}")

    def _set_surroundings(self, T_map_camera: RigidTransform) -> None:
        """Set the surroundings at the first pose, which aligns scene and map."""
        if (
            self._surroundings is None
            and self._scene is not None
            and self._ground_truth is not None
        ):
            self._surroundings = Surroundings.with_ground_truth(
                self._scene, self._ground_truth, T_map_camera
            )

    def _drop_old_frames(self) -> None:
        """Drop old frames. Lists are replaced, because pending moments may use the old ones."""
        if len(self._rows) > MOST_FRAMES:
            self._rows = self._rows[MOST_FRAMES // 2 :]
            self._path = self._path[-len(self._rows) :]
            self._odometry.truncate(MOST_FRAMES // 2)

    def _put(self, message: str) -> None:
        assert self._last is not None
        last, rows = self._last, self._rows
        count = len(rows)
        self._dashboard.put(lambda: self._state(last, rows, count, message))

    def _state(
        self, last: _Moment, rows: Sequence[Mapping[str, Any]], count: int, message: str
    ) -> DashboardState:
        """Create the state; runs in the dashboard's thread."""
        step, frame, target, model = last
        pose = None if step.pose is None else step.pose.T_map_camera
        return DashboardState(
            rows=rows,
            count=count,
            object_snapshot=_object_snapshot(model, step.grid),
            images=None if frame is None else FrameImages(frame.depth, frame.colour, step.index),
            camera=None if frame is None else frame.camera,
            T_map_camera=pose,
            T_base_camera=None if frame is None else frame.T_base_camera,
            path_xyz=_stacked(self._path),
            odometry_xyz=_stacked(self._odometry.places_xyz),
            target=target,
            surroundings=self._surroundings,
            truth=self._truth,
            message=message,
            run=self,
        )


def _object_snapshot(model: ObjectModel, grid: OccupancyGrid | None) -> ObjectSnapshot:
    try:
        cloud, seen = model.cloud(), model.frames_seen()
    except GeometryError:
        return ObjectSnapshot()
    normals = cloud.normals_xyz
    return ObjectSnapshot(
        cloud.points_xyz,
        np.zeros_like(cloud.points_xyz) if normals is None else normals,
        seen,
        grid,
    )


def _stacked(places: Sequence[ArrayLike]) -> NDArray[np.floating]:
    return np.array(places[:]) if places else NOTHING
