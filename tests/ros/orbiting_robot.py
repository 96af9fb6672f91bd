"""A robot that drives round a chair and publishes what it sees; and a bus in memory to do so."""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.furniture import make_furniture
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import (
    odometry_message,
    transform_message,
    transforms_message,
)
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, ODOMETRY, TRANSFORMS
from circumspect.ros.middleware import MessageCallback, Middleware, Quality
from circumspect.ros.wire_messages import deserialized, serialized
from circumspect.sensing import DepthNoise, Odometry, RgbdFrame
from circumspect.simulation import CameraMount, Orbit, Scene, SimulatedCamera

CAMERA = PinholeCamera(320, 240, 285.0, 285.0, 159.5, 119.5)
DEPTH, INFO, ODOM = "/camera/depth/image_rect_raw", "/camera/depth/camera_info", "/odom"
OPTICAL = "camera_depth_optical_frame"
STATIC = Quality(latched=True, depth=1)
BEST_EFFORT, RELIABLE = Quality(reliable=False), Quality()
INTERVAL = 0.2


@cache
def orbit() -> tuple[RigidTransform, tuple[tuple[RgbdFrame, PlanarPose], ...]]:
    """The camera's mount, and frames with the robot's true place, a third of the way round."""
    chair = make_furniture("chair", 3)
    path = Orbit.around(chair, CAMERA, start=0.5)
    mount = CameraMount.for_orbit(path).T_base_camera
    stations = path.stations(60)
    scene = Scene.with_object(chair)
    frames = SimulatedCamera(scene, stations.__next__, CAMERA, DepthNoise(), 0).frames(20)
    frames_and_poses = [(f, PlanarPose.from_transform(f.pose * mount.inv())) for f in frames]
    return mount, tuple(frames_and_poses)


class MemoryBus(Middleware):
    """Carries messages within the process, at once and in the publisher's thread."""

    def __init__(self) -> None:
        self.published: dict[str, list[tuple[str, bytes]]] = defaultdict(list)
        self.offered: dict[str, tuple[str, Quality]] = {}
        self.wanted: dict[str, tuple[str, Quality]] = {}
        self._subscribers: dict[str, list[MessageCallback]] = defaultdict(list)
        self._lock = threading.Lock()

    def subscribe(
        self, topic: str, kind: str, quality: Quality, published: MessageCallback
    ) -> None:
        self.wanted[topic] = kind, quality
        self._subscribers[topic].append(published)

    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        self.offered[topic] = kind, quality

        def publish(data: bytes) -> None:
            with self._lock:
                self.published[topic].append((kind, data))
            for published in self._subscribers[topic]:
                published(data)

        return publish

    def received(self, topic: str) -> list[Any]:
        """All messages that were published on a topic."""
        with self._lock:
            return [deserialized(kind, data) for kind, data in self.published[topic]]

    def publishers(self, topic: str) -> int:
        return int(topic in self.offered)

    @property
    def lost(self) -> int:
        return 0

    def close(self) -> None:
        self._subscribers.clear()


class OrbitingRobot:
    """Publishes frames of `orbit`: CameraInfo, odometry or transforms, and depth."""

    def __init__(
        self,
        middleware: Middleware,
        quality: Quality = BEST_EFFORT,
        odometry: bool = True,
        odom_frame: str = "odom",
    ) -> None:
        mount, self.frames = orbit()
        self.odometry, self.odom_frame = odometry, odom_frame

        def offer(topic: str, kind: str, quality: Quality) -> Callable[[Any], None]:
            publish = middleware.advertise(topic, kind, quality)
            return lambda msg: publish(serialized(kind, msg))

        self.publish_depth = offer(DEPTH, IMAGE, quality)
        self.publish_info = offer(INFO, CAMERA_INFO, quality)
        self.publish_odometry = offer(ODOM, ODOMETRY, quality)
        self.publish_tf = offer("/tf", TRANSFORMS, Quality(depth=100))
        self.publish_static = offer("/tf_static", TRANSFORMS, STATIC)
        self.mount = transforms_message([transform_message(mount, 0.0, "base_link", OPTICAL)])

    def publish_mount(self) -> None:
        """Publish where the camera is mounted."""
        self.publish_static(self.mount)

    def publish_frame(self, number: int, late: float = 0.0) -> None:
        """Publish one frame; its stamps are `late` [s] later than usual."""
        frame, place = self.frames[number]
        stamp = 100.0 + INTERVAL * number + late
        self.publish_place(stamp, place)
        self.publish_info(camera_info(frame.camera, stamp, OPTICAL))
        self.publish_depth(depth_message(frame.depth, stamp, OPTICAL))

    def publish_place(self, stamp: float, place: PlanarPose) -> None:
        if self.odometry:
            covariance = np.diag([1e-6, 1e-6, 1e-6])
            msg = Odometry(stamp, place, covariance)
            self.publish_odometry(odometry_message(msg, self.odom_frame, "base_link"))
        else:
            moved = transform_message(place.as_transform(), stamp, self.odom_frame, "base_link")
            self.publish_tf(transforms_message([moved]))
