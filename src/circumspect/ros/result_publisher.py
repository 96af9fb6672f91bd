"""Publisher of the node's results."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import GeometryError
from circumspect.geometry.composition import between, composed
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
from circumspect.ros.output_messages import (
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
from circumspect.ros.wire_messages import serialized
from circumspect.sensing import RgbdFrame
from circumspect.tracking import PoseEstimate, PoseEstimator

PUBLISH_INTERVAL_S = 1.0
"""Interval between two models, paths and next views, which are large or slow to compute [s]."""
NO_POINTS = np.empty((0, 3))
MIN_STEP_M, MIN_TURN_RAD = 0.02, float(np.radians(5.0))
"""Minimum distance between two logged poses [m, rad]."""
MAX_POSES = 500
"""Maximum number of logged poses; beyond it, every second one is removed."""


class PathLog:
    """Poses of reliably tracked frames, corrected as the map improves."""

    def __init__(self) -> None:
        self._poses: list[tuple[float, PoseEstimate, RigidTransform]] = []

    def __len__(self) -> int:
        return len(self._poses)

    def add(self, stamp: float, pose: PoseEstimate, T_base_camera: RigidTransform | None) -> None:
        """Add the pose of a frame, if it is reliable and not close to the previous one.

        Args:
            stamp: Stamp of the frame [s].
            pose: Pose of the camera.
            T_base_camera: Mount of the camera; without it the path is that of the camera.
        """
        if not pose.reliable:
            return
        if self._poses:
            moved = between(self._poses[-1][1].T_map_camera, pose.T_map_camera)
            step, turn = np.linalg.norm(moved.translation), moved.rotation.magnitude()
            if step < MIN_STEP_M and turn < MIN_TURN_RAD:
                return
        mount = RigidTransform.identity() if T_base_camera is None else T_base_camera
        self._poses.append((stamp, pose, mount.inv()))
        if len(self._poses) > MAX_POSES:
            del self._poses[1:-1:2]

    def path(self, poses: PoseEstimator) -> list[tuple[float, RigidTransform]]:
        """The current estimate of the path: stamps [s] and poses of the robot.

        Args:
            poses: The estimator of the poses.
        """
        corrected = poses.corrected([estimate for _, estimate, _ in self._poses])
        return [
            (stamp, composed(T_map_camera, T_camera_base))
            for (stamp, _, T_camera_base), T_map_camera in zip(self._poses, corrected, strict=True)
        ]


class ResultPublisher:
    """Publishes model, detections, path and next_view below the node's name, /diagnostics and /tf.

    Attributes:
        next_view: The last published next view; None if there is none.
    """

    def __init__(
        self,
        middleware: Middleware,
        settings: NodeSettings,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Advertise the topics.

        Args:
            middleware: Transport of the messages.
            settings: Settings of the node.
            clock: Current time [s].
        """
        self._settings, self._clock, self._frame = settings, clock, settings.output_frame

        def advertised(name: str, kind: str, quality: Quality) -> Callable[[Any], None]:
            return _publisher_of(
                kind, middleware.advertise(f"{settings.node}/{name}", kind, quality)
            )

        self._publish_model = advertised("model", POINTS, LATEST)
        self._publish_detections = advertised("detections", DETECTIONS, ANSWERS)
        self._publish_path = advertised("path", PATH, LATEST)
        self._publish_view = advertised("next_view", POSE, LATEST)
        self._publish_status = _publisher_of(
            DIAGNOSTICS, middleware.advertise("/diagnostics", DIAGNOSTICS, REPORTS)
        )
        self._publish_transforms: Callable[[Any], None] | None = None
        if settings.transforms and settings.poses == "found":
            self._publish_transforms = _publisher_of(
                TRANSFORMS, middleware.advertise(TF, TRANSFORMS, Quality(depth=100))
            )
        self._stamp = 0.0
        self._has_detections = False
        self.next_view: NextView | None = None
        self._clear()

    def _clear(self) -> None:
        self._path, self._views = PathLog(), NextViews(self._settings.noise.depth_range)
        self._published_at = -float("inf")

    def step(
        self, step: RecognitionStep, frame: RgbdFrame, poses: PoseEstimator, odom_frame: str
    ) -> None:
        """Publish the results of a frame.

        Args:
            step: Result of the pipeline.
            frame: The frame.
            poses: The estimator of the poses.
            odom_frame: Name of the odometry frame.
        """
        self._stamp = step.stamp
        self._views.update(step, frame)
        if step.pose is not None:
            self._path.add(step.stamp, step.pose, frame.T_base_camera)
            self._update_transform(step, frame, odom_frame)
        if step.prediction is None:
            self._retract_detections()
            self._retract_view()
        if step.outcome != FrameOutcome.CLASSIFIED or step.prediction is None:
            return
        self._update_answer(step.model.preview, step.prediction)
        if self._clock() - self._published_at >= PUBLISH_INTERVAL_S:
            self._published_at = self._clock()
            self._update_model_and_path(step.model.preview, poses)
            self._update_next_view(step, frame)

    def finalised(self, pipeline: RecognitionPipeline) -> None:
        """Publish the final results while no more frames arrive."""
        if pipeline.prediction is None:
            self._retract_detections()
            return
        self._update_answer(pipeline.model, pipeline.prediction)
        self._update_model_and_path(pipeline.model, pipeline.tracker)

    def reset(self) -> None:
        """Publish empty results, which replace the previous ones."""
        self._clear()
        self._publish_model(points_message(NO_POINTS, None, self._stamp, self._frame))
        self._has_detections = False
        self._publish_detections(no_detections(self._stamp, self._frame))
        self._publish_path(path_message([], self._stamp, self._frame))
        self._retract_view()

    def status(self, status: Status) -> None:
        """Publish the status of the node."""
        name, hardware_id = self._settings.node.removeprefix("/"), self._settings.depth_topic
        msg = (status.level, f"{name}: recognition", status.text, hardware_id, status.values)
        self._publish_status(diagnostics_message(*msg, time.time()))

    def _update_transform(self, step: RecognitionStep, frame: RgbdFrame, odom_frame: str) -> None:
        """Publish the transform from the odometry frame to the output frame."""
        pose = step.pose
        if self._publish_transforms is None or pose is None or pose.T_map_odom is None:
            return
        if frame.odometry is None or not pose.reliable:
            return
        T_odom_output = pose.T_map_odom.inverse().as_transform()
        moved = transform_message(T_odom_output, step.stamp, odom_frame, self._frame)
        self._publish_transforms(transforms_message([moved]))

    def _update_answer(self, model: ObjectModel, prediction: Prediction) -> None:
        try:
            points = model.cloud().points_xyz
        except GeometryError:
            return
        extent = np.stack([points.min(axis=0), points.max(axis=0)])
        self._has_detections = True
        self._publish_detections(detections_message(prediction, extent, self._stamp, self._frame))

    def _update_model_and_path(self, model: ObjectModel, poses: PoseEstimator) -> None:
        cloud = model.cloud()
        msg = points_message(cloud.points_xyz, cloud.normals_xyz, self._stamp, self._frame)
        self._publish_model(msg)
        self._publish_path(path_message(self._path.path(poses), self._stamp, self._frame))

    def _update_next_view(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        view = self._views.next_view(step, frame)
        if not isinstance(view, NextView):
            self._retract_view()
            return
        self.next_view = view
        place: RigidTransform = view.T_map_base.as_transform()
        self._publish_view(stamped_pose(place, self._stamp, self._frame))

    def _retract_detections(self) -> None:
        """Withdraw the answer, for instance of an object that turned out to be too wide."""
        if self._has_detections:
            self._has_detections = False
            self._publish_detections(no_detections(self._stamp, self._frame))

    def _retract_view(self) -> None:
        """Withdraw the next view, so that late subscribers do not receive it."""
        if self.next_view is not None:
            self.next_view = None
            self._publish_view(no_pose(self._stamp))


def _publisher_of(kind: str, publish: Callable[[bytes], None]) -> Callable[[Any], None]:
    def publish_message(msg: Any) -> None:
        publish(serialized(kind, msg))

    return publish_message
