"""Recording of a run as ROS 2 messages."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import InputError, OutputError
from circumspect.geometry import PlanarPose
from circumspect.localization import CeilingImage, LensCamera
from circumspect.recording.image_messages import (
    camera_info,
    camera_of,
    colour_message,
    depth_message,
    depth_of,
    grey_message,
)
from circumspect.recording.mcap_writer import McapWriter
from circumspect.recording.pose_messages import (
    odometry_message,
    odometry_of,
    pose_message,
    transform_message,
    transform_of,
    transforms_message,
    vector_message,
)
from circumspect.recording.ros_time import NANOSECONDS, header, nanoseconds
from circumspect.recording.ros_types import (
    CAMERA_INFO,
    DETECTIONS,
    IMAGE,
    ODOMETRY,
    TRANSFORMS,
    message,
)
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import Odometry, RgbdFrame

DEPTH_TOPIC, DEPTH_INFO = "/camera/depth/image_raw", "/camera/depth/camera_info"
COLOUR_TOPIC = "/camera/color/image_raw"
ODOMETRY_TOPIC, TF_TOPIC, STATIC_TOPIC = "/odom", "/tf", "/tf_static"
DETECTIONS_TOPIC = "/circumspect/detections"
MAP, ODOM, BASE, OPTICAL = "map", "odom", "base_link", "camera_optical"
SYNCHRONOUS = "synchronous"
"""Note: the odometry before each depth image belongs to that image."""
SYSTEMATIC_DISPARITY = "systematic_disparity"
"""Note: systematic disparity error of the camera [rad], see `DepthNoise`."""
_log = logging.getLogger(__name__)


class RecordingRobot(WrappedRobot):
    """Records each observed frame and returns it as the recording contains it."""

    def __init__(self, robot: MobileRobot, recorder: RunRecorder) -> None:
        """Wrap a robot; this must be the outermost wrapper."""
        super().__init__(robot)
        self._recorder = recorder

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        return self._recorder.frame(self.robot.observe())


class RunRecorder:
    """Records frames and predictions into one MCAP file.

    A write error, such as a full disk, ends the recording but not the run; see `failure`.

    Attributes:
        failure: Why the recording ended early; None otherwise.
    """

    def __init__(self, path: str | os.PathLike[str], notes: Mapping[str, str]) -> None:
        """Create a file; see `McapWriter`."""
        self._writer = McapWriter(path, {SYNCHRONOUS: "true", **notes})
        self.failure: OutputError | None = None
        self._mount: RigidTransform | None = None
        self._last = 0

    def frame(self, frame: RgbdFrame) -> RgbdFrame:
        """Record a frame.

        Returns:
            The frame as read from the recording: depth, stamps and poses are rounded as in the
            messages, so that a replay repeats the run exactly. A frame that cannot be recorded
            (its stamp is negative) is returned unchanged.
        """
        with self._logged_errors("a frame"):
            return self._recorded(frame)
        return frame

    def _recorded(self, frame: RgbdFrame) -> RgbdFrame:
        stamp = nanoseconds(frame.stamp) / NANOSECONDS
        self._last = log_time = max(self._last, nanoseconds(frame.stamp))
        mount = self._recorded_mount(frame.T_base_camera, stamp, log_time)
        odometry = self._recorded_odometry(frame.odometry, log_time)
        info = camera_info(frame.camera, stamp, OPTICAL)
        self._writer.write(DEPTH_INFO, CAMERA_INFO, log_time, info)
        if frame.colour is not None:
            colour = colour_message(frame.colour, stamp, OPTICAL)
            self._writer.write(COLOUR_TOPIC, IMAGE, log_time, colour)
        depth = depth_message(frame.depth, stamp, OPTICAL)
        self._writer.write(DEPTH_TOPIC, IMAGE, log_time, depth)
        return replace(
            frame, depth=depth_of(depth), camera=camera_of(info), stamp=stamp, odometry=odometry,
            T_base_camera=mount,
        )  # fmt: skip

    def _recorded_mount(
        self, T_base_camera: RigidTransform | None, stamp: float, log_time: int
    ) -> RigidTransform | None:
        if T_base_camera is None:
            return None
        msg = transform_message(T_base_camera, stamp, BASE, OPTICAL)
        before = self._mount
        if before is None or not np.array_equal(before.as_matrix(), T_base_camera.as_matrix()):
            self._writer.write(
                STATIC_TOPIC, TRANSFORMS, log_time, transforms_message([msg]), latched=True
            )
            self._mount = T_base_camera
        return transform_of(msg.transform.translation, msg.transform.rotation)

    def _recorded_odometry(self, odometry: Odometry | None, log_time: int) -> Odometry | None:
        if odometry is None:
            return None
        msg = odometry_message(odometry, ODOM, BASE)
        self._writer.write(ODOMETRY_TOPIC, ODOMETRY, log_time, msg)
        moved = transform_message(odometry.T_odom_base.as_transform(), odometry.stamp, ODOM, BASE)
        self._writer.write(TF_TOPIC, TRANSFORMS, log_time, transforms_message([moved]))
        return odometry_of(msg)

    def answer(
        self,
        stamp: float,
        prediction: Prediction | None,
        extent_xyz: NDArray[np.floating] | None,
        T_map_odom: PlanarPose | None,
    ) -> None:
        """Record the result of a frame.

        Args:
            stamp: Stamp of the frame [s].
            prediction: Current prediction, or None.
            extent_xyz: (2, 3) lowest and highest corner of the model in the map frame [m], or None.
            T_map_odom: Correction of the odometry, or None.
        """
        with self._logged_errors("a prediction"):
            self._answer(stamp, prediction, extent_xyz, T_map_odom)

    def _answer(
        self,
        stamp: float,
        prediction: Prediction | None,
        extent_xyz: NDArray[np.floating] | None,
        T_map_odom: PlanarPose | None,
    ) -> None:
        log_time = max(self._last, nanoseconds(stamp))
        if T_map_odom is not None:
            moved = transform_message(T_map_odom.as_transform(), stamp, MAP, ODOM)
            self._writer.write(TF_TOPIC, TRANSFORMS, log_time, transforms_message([moved]))
        if prediction is not None and extent_xyz is not None:
            msg = detections_message(prediction, extent_xyz, stamp)
            self._writer.write(DETECTIONS_TOPIC, DETECTIONS, log_time, msg)

    def ceiling_image(self, image: CeilingImage, lens: LensCamera) -> None:
        """Record an image of a ceiling camera on /CAMERA/image_raw, with its CameraInfo.

        Args:
            image: The image.
            lens: Lens of its camera.
        """
        name, stamp = image.camera, image.stamp
        with self._logged_errors(f"an image of {name}"):
            log_time = max(self._last, nanoseconds(stamp))
            info = camera_info(lens.pinhole, stamp, name, lens.distortion)
            self._writer.write(f"/{name}/camera_info", CAMERA_INFO, log_time, info)
            grey = grey_message(image.grey, stamp, name)
            self._writer.write(f"/{name}/image_raw", IMAGE, log_time, grey)

    def close(self) -> None:
        """Write the index and close the file; an error is stored in `failure`."""
        with self._logged_errors("the index"):
            self._writer.close()

    def discard(self) -> None:
        """Remove the recording of a run that could not start."""
        self._writer.discard()

    @contextmanager
    def _logged_errors(self, what: str) -> Iterator[None]:
        """Log errors of the recording so that the run continues."""
        try:
            yield
        except OutputError as error:
            if self.failure is None:
                self.failure = error
                _log.warning("%s", error)
        except InputError as error:
            _log.warning("%s is missing from the recording: %s", what, error)


def detections_message(
    prediction: Prediction, extent_xyz: NDArray[np.floating], stamp: float, frame_id: str = MAP
) -> object:
    """Create a `vision_msgs/Detection3DArray` of one object with all classes, most likely first.

    Args:
        prediction: Prediction of the object.
        extent_xyz: (2, 3) lowest and highest corner in the map frame [m].
        stamp: Time [s].
        frame_id: Name of the map frame.
    """
    centre = pose_message(RigidTransform.from_translation(extent_xyz.mean(axis=0)))
    unknown = message("geometry_msgs/msg/PoseWithCovariance", pose=centre, covariance=np.zeros(36))
    likeliest = sorted(prediction.probabilities.items(), key=lambda pair: -pair[1])
    results = [
        message(
            "vision_msgs/msg/ObjectHypothesisWithPose",
            hypothesis=message("vision_msgs/msg/ObjectHypothesis", class_id=name, score=score),
            pose=unknown,
        )
        for name, score in likeliest
    ]
    box = message("vision_msgs/msg/BoundingBox3D", center=centre,
                  size=vector_message(extent_xyz[1] - extent_xyz[0]))  # fmt: skip
    head = header(stamp, frame_id)
    one = message("vision_msgs/msg/Detection3D", header=head, results=results, bbox=box, id="0")
    return message(DETECTIONS, header=head, detections=[one])
