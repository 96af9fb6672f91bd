"""Publishes what the node knows."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import GeometryError
from circumspect.planning import NextView
from circumspect.recognition import FrameOutcome, RecognitionPipeline, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.recording.pose_messages import transform_message, transforms_message
from circumspect.recording.ros_types import DETECTIONS, TRANSFORMS
from circumspect.recording.run_recorder import detections_message
from circumspect.ros.health import Status
from circumspect.ros.live_frames import TF
from circumspect.ros.middleware import ANSWERS, LATEST, REPORTS, Middleware, Quality
from circumspect.ros.next_views import NextViews
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.outgoing import (
    DIAGNOSTICS,
    PATH,
    POINTS,
    POSE,
    diagnostics_message,
    no_detections,
    no_pose,
    path_message,
    points_message,
    stamped_pose,
)
from circumspect.ros.path_log import PathLog
from circumspect.ros.wire_messages import packed
from circumspect.sensing import RgbdFrame
from circumspect.tracking import PoseEstimator

EVERY = 1.0
"""Between two models, paths and next views, which are large or take long [s]."""
NOTHING = np.empty((0, 3))


class Announcer:
    """Topics below the node's name: model, detections, path, next_view; /diagnostics and /tf.

    Attributes:
        advised: The next view that was told last; None where none is advised any more.
    """

    def __init__(
        self,
        middleware: Middleware,
        settings: NodeSettings,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Advertise.

        Args:
            middleware: Carries the messages.
            settings: Of the node.
            clock: Gives the time [s].
        """
        self._settings, self._clock, self._frame = settings, clock, settings.told_frame

        def below(name: str, kind: str, quality: Quality) -> Callable[[Any], None]:
            return _packing(kind, middleware.advertise(f"{settings.node}/{name}", kind, quality))

        self._tell_model = below("model", POINTS, LATEST)
        self._tell_answer = below("detections", DETECTIONS, ANSWERS)
        self._tell_path = below("path", PATH, LATEST)
        self._tell_view = below("next_view", POSE, LATEST)
        self._tell_status = _packing(
            DIAGNOSTICS, middleware.advertise("/diagnostics", DIAGNOSTICS, REPORTS)
        )
        self._tell_transforms: Callable[[Any], None] | None = None
        if settings.transforms and settings.poses == "found":
            self._tell_transforms = _packing(
                TRANSFORMS, middleware.advertise(TF, TRANSFORMS, Quality(depth=100))
            )
        self._stamp = 0.0
        self._answered = False
        self.advised: NextView | None = None
        self._begin()

    def _begin(self) -> None:
        self._path, self._views = PathLog(), NextViews(self._settings.noise.depth_range)
        self._told_at = -float("inf")

    def step(
        self, step: RecognitionStep, frame: RgbdFrame, poses: PoseEstimator, odom_frame: str
    ) -> None:
        """Tell what a frame led to.

        Args:
            step: What the pipeline made of it.
            frame: The frame.
            poses: Of all frames so far.
            odom_frame: What the frame of the odometry is called.
        """
        self._stamp = step.stamp
        self._views.heard(step, frame)
        if step.pose is not None:
            self._path.heard(step.stamp, step.pose, frame.T_base_camera)
            self._tell_place(step, frame, odom_frame)
        if step.prediction is None:
            self._retract_answer()
            self._retract_view()
        if step.outcome != FrameOutcome.CLASSIFIED or step.prediction is None:
            return
        self._answer(step.model.preview, step.prediction)
        if self._clock() - self._told_at >= EVERY:
            self._told_at = self._clock()
            self._model_and_path(step.model.preview, poses)
            self._next_view(step, frame)

    def settled(self, pipeline: RecognitionPipeline) -> None:
        """Tell what is known when no more frames come for now."""
        if pipeline.prediction is None:
            self._retract_answer()
            return
        self._answer(pipeline.model, pipeline.prediction)
        self._model_and_path(pipeline.model, pipeline.tracker)

    def reset(self) -> None:
        """Tell that nothing of what was told holds any more."""
        self._begin()
        self._tell_model(points_message(NOTHING, None, self._stamp, self._frame))
        self._answered = False
        self._tell_answer(no_detections(self._stamp, self._frame))
        self._tell_path(path_message([], self._stamp, self._frame))
        self._retract_view()

    def status(self, status: Status) -> None:
        """Tell how the node fares."""
        name, about = self._settings.node.removeprefix("/"), self._settings.depth_topic
        told = (status.level, f"{name}: recognition", status.text, about, status.values)
        self._tell_status(diagnostics_message(*told, time.time()))

    def _tell_place(self, step: RecognitionStep, frame: RgbdFrame, odom_frame: str) -> None:
        """Hang the frame in which all is told below that of the odometry."""
        pose = step.pose
        if self._tell_transforms is None or pose is None or pose.T_map_odom is None:
            return
        if frame.odometry is None or not pose.reliable:
            return
        T_odom_told = pose.T_map_odom.inverse().as_transform()
        moved = transform_message(T_odom_told, step.stamp, odom_frame, self._frame)
        self._tell_transforms(transforms_message([moved]))

    def _answer(self, model: ObjectModel, prediction: Prediction) -> None:
        try:
            points = model.cloud().points_xyz
        except GeometryError:
            return
        extent = np.stack([points.min(axis=0), points.max(axis=0)])
        self._answered = True
        self._tell_answer(detections_message(prediction, extent, self._stamp, self._frame))

    def _model_and_path(self, model: ObjectModel, poses: PoseEstimator) -> None:
        cloud = model.cloud()
        told = points_message(cloud.points_xyz, cloud.normals_xyz, self._stamp, self._frame)
        self._tell_model(told)
        self._tell_path(path_message(self._path.path(poses), self._stamp, self._frame))

    def _next_view(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        view = self._views.advice(step, frame)
        if not isinstance(view, NextView):
            self._retract_view()
            return
        self.advised = view
        place: RigidTransform = view.T_map_base.as_transform()
        self._tell_view(stamped_pose(place, self._stamp, self._frame))

    def _retract_answer(self) -> None:
        """What turned out to be wider than anything that has a name has none any more."""
        if self._answered:
            self._answered = False
            self._tell_answer(no_detections(self._stamp, self._frame))

    def _retract_view(self) -> None:
        """Else who comes late would be sent to a view that is none any more."""
        if self.advised is not None:
            self.advised = None
            self._tell_view(no_pose(self._stamp))


def _packing(kind: str, publish: Callable[[bytes], None]) -> Callable[[Any], None]:
    def tell(told: Any) -> None:
        publish(packed(kind, told))

    return tell
