"""Watches a run on behalf of a dashboard; the run never waits for it."""

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
from circumspect.runs.odometry_path import OdometryPath
from circumspect.runs.surroundings import Surroundings
from circumspect.sensing import RgbdFrame
from circumspect.simulation import Scene, Witness
from circumspect.viewer.dashboard import Dashboard
from circumspect.viewer.shown import NOTHING, Shown, ShownImages, ShownObject

_Moment = tuple[RecognitionStep, RgbdFrame | None, PlannedView | None, ObjectModel]

MOST_FRAMES = 20_000
"""So many are remembered, more than an hour at five a second; then the older half is forgotten."""


class Watchable(Protocol):
    """A run that can be watched: an `ObjectScan`, `OperatedFrames`, a node."""

    @property
    def frame(self) -> RgbdFrame | None:
        """The frame that is worked on."""
        ...

    @property
    def target(self) -> PlannedView | None:
        """The view that the robot drives to, or should."""
        ...

    @property
    def ended(self) -> str | None:
        """Why the run ended; None while it goes on."""
        ...


class LiveWatch:
    """Puts the newest state where the dashboard's thread takes it; a `PipelineObserver`.

    In the run's own thread only references and a few numbers are kept; points, colours and
    pictures are made by the dashboard's.

    Attributes:
        news: A line about the run as a whole, shown until it ends.
    """

    def __init__(
        self,
        run: Watchable,
        dashboard: Dashboard,
        scene: Scene | None = None,
        witness: Witness | None = None,
        truth: str | None = None,
    ) -> None:
        """Watch a run.

        Args:
            run: Not yet begun.
            dashboard: Shows it.
            scene: What stands around, where that is known.
            witness: Knows how the scene lies in the robot's map.
            truth: The object's true class, where that is known.
        """
        self.news = ""
        self._run, self._dashboard = run, dashboard
        self._scene, self._witness, self._truth = scene, witness, truth
        self._rows: list[Mapping[str, Any]] = []
        self._path: list[NDArray[np.float64]] = []
        self._odometry = OdometryPath()
        self._surroundings: Surroundings | None = None
        self._last: _Moment | None = None

    def on_step(self, step: RecognitionStep) -> None:
        """Put the step into the slot."""
        frame, target = self._run.frame, self._run.target
        self._rows.append(step.summary())
        if step.pose is not None:
            self._look_round(step.pose.T_map_camera)
            self._path.append(step.pose.T_map_camera.translation)
        self._odometry.add(step, frame)
        self._forget()
        # All of a large model would keep the run waiting.
        self._last = (step, frame, target, step.model.preview)
        self._put(self.news)

    def tell(self, news: str) -> None:
        """Show a line about the run, from now until it ends; may be called from any thread."""
        self.news = news
        if self._last is None:
            self._dashboard.put(lambda: Shown((), 0, news=news, run=self))
        else:
            self._put(news)

    def settled(self, prediction: Prediction) -> None:
        """Show the answer when no more frames come for now.

        Args:
            prediction: Over all grids.
        """
        if self._last is None:
            return
        step, frame, target, model = self._last
        coverage = step.coverage if prediction.coverage is None else prediction.coverage
        step = replace(step, prediction=prediction, coverage=coverage)
        self._last = (step, frame, target, model)
        self._rows = [*self._rows[:-1], step.summary()]
        self._put(self.news)

    def on_end(self, result: RecognitionResult) -> None:
        """Show how it ended, with what was corrected in the end."""
        if self._last is None or result.last is None:
            return
        _, frame, target, _ = self._last
        self._path = [s.pose.T_map_camera.translation for s in result.steps if s.pose is not None]
        self._last = (result.last, frame, target, result.last.model)
        if self._rows:
            self._rows[-1] = result.last.summary()
        early = result.end_reason or "interrupted" if result.interrupted else ""
        self._put(f"the run is over: {self._run.ended or early or 'no more frames'}")

    def _look_round(self, T_map_camera: RigidTransform) -> None:
        """With the first pose it is known how the scene lies in the robot's map."""
        if self._surroundings is None and self._scene is not None and self._witness is not None:
            self._surroundings = Surroundings.witnessed(self._scene, self._witness, T_map_camera)

    def _forget(self) -> None:
        """A robot may drive for days. Lists are replaced: what was put may still need the old."""
        if len(self._rows) > MOST_FRAMES:
            self._rows = self._rows[MOST_FRAMES // 2 :]
            self._path = self._path[-len(self._rows) :]
            self._odometry.truncate(MOST_FRAMES // 2)

    def _put(self, news: str) -> None:
        assert self._last is not None
        last, rows = self._last, self._rows
        count = len(rows)
        self._dashboard.put(lambda: self._shown(last, rows, count, news))

    def _shown(
        self, last: _Moment, rows: Sequence[Mapping[str, Any]], count: int, news: str
    ) -> Shown:
        """Made by the dashboard's thread, while the run goes on."""
        step, frame, target, model = last
        pose = None if step.pose is None else step.pose.T_map_camera
        return Shown(
            rows=rows,
            count=count,
            thing=_thing(model, step.grid),
            images=None if frame is None else ShownImages(frame.depth, frame.colour, step.index),
            camera=None if frame is None else frame.camera,
            T_map_camera=pose,
            T_base_camera=None if frame is None else frame.T_base_camera,
            path_xyz=_stacked(self._path),
            odometry_xyz=_stacked(self._odometry.places_xyz),
            target=target,
            surroundings=self._surroundings,
            truth=self._truth,
            news=news,
            run=self,
        )


def _thing(model: ObjectModel, grid: OccupancyGrid | None) -> ShownObject:
    try:
        cloud, seen = model.cloud(), model.frames_seen()
    except GeometryError:
        return ShownObject()
    normals = cloud.normals_xyz
    return ShownObject(
        cloud.points_xyz,
        np.zeros_like(cloud.points_xyz) if normals is None else normals,
        seen,
        grid,
    )


def _stacked(places: Sequence[ArrayLike]) -> NDArray[np.floating]:
    return np.array(places[:]) if places else NOTHING
