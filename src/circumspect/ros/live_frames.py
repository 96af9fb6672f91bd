"""Assembly of frames from messages as they arrive."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, MutableMapping
from dataclasses import replace
from typing import Any

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.bag import BagMessage
from circumspect.recording.frame_assembly import AssemblySettings, ClockError, FrameAssembly
from circumspect.recording.ros_time import NANOSECONDS, nanoseconds_of, set_nanoseconds
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, ODOMETRY, TRANSFORMS
from circumspect.recording.topic_choice import ChosenTopics
from circumspect.ros.health import Health
from circumspect.ros.middleware import (
    CAMERA_INFO_LATCHED,
    SENSOR,
    STATIC_TRANSFORMS,
    STATIC_TRANSFORMS_VOLATILE,
    TRANSFORMS_QUALITY,
    Middleware,
    Quality,
)
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.wire_messages import deserialized
from circumspect.sensing import RgbdFrame
from circumspect.sensing.viewing import looking

TF, TF_STATIC = "/tf", "/tf_static"
MAX_PIXELS = 4_000_000
"""Maximum number of pixels of a depth image; larger ones are skipped."""
MIN_INTERVAL_FRACTION = 0.9
"""A frame is due after this fraction of the frame interval, because camera intervals vary."""

_log = logging.getLogger(__name__)


class LiveFrames:
    """Subscribes to a robot's topics; frames wait in a queue that drops the oldest."""

    def __init__(
        self,
        middleware: Middleware,
        settings: NodeSettings,
        health: Health,
        clock: Callable[[], float] = time.monotonic,
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        """Subscribe to the topics.

        Args:
            middleware: Transport of the messages.
            settings: Settings of the node.
            health: Receives counts and errors.
            clock: Time of arrival [s].
            wall_clock: Time for messages without a stamp [s].

        Raises:
            InputError: The middleware rejects a topic.
        """
        self.taking = False
        """Whether depth images are processed."""
        self.backward_jumps = 0
        """Number of backward jumps of the stamps; each starts a new time."""
        self._settings, self._health, self._clock = settings, health, clock
        self._condition = threading.Condition()
        self._message_lock = threading.RLock()
        self._queue: deque[RgbdFrame] = deque()
        self._due = -float("inf")
        self._wall_clock = wall_clock
        self._zero_stamps: dict[str, int] = {}
        """Topic to the number of its last consecutive messages with a zero stamp."""
        self._last: dict[str, bytes] = {}
        """Last message of topics with several subscriptions."""
        self._has_pose = True
        self._topics = ChosenTopics(
            settings.depth_topic, settings.info_topic, None, settings.odometry_topic,
            (TF, TF_STATIC),
        )  # fmt: skip
        self._assembly = FrameAssembly(
            self._topics, _assembly_settings(settings), _SkippedReasons(health)
        )
        self._middleware = middleware
        self._subscribe_all()

    def _subscribe_all(self) -> None:
        sensor = replace(SENSOR, reliable=self._settings.reliable)
        # Each quality of service that a publisher may offer needs its own subscription.
        wanted: list[tuple[str | None, str, Quality, str]] = [
            (TF_STATIC, TRANSFORMS, STATIC_TRANSFORMS_VOLATILE, "static transforms"),
            (self._topics.info, CAMERA_INFO, CAMERA_INFO_LATCHED, "camera info"),
            (TF_STATIC, TRANSFORMS, STATIC_TRANSFORMS, "static transforms"),
            (TF, TRANSFORMS, TRANSFORMS_QUALITY, "transforms"),
            (self._topics.info, CAMERA_INFO, sensor, "camera info"),
            (self._topics.odometry, ODOMETRY, sensor, "odometry"),
            (self._topics.depth, IMAGE, sensor, "depth"),
        ]
        for topic, kind, quality, what in wanted:
            if topic is not None:
                self._middleware.subscribe(topic, kind, quality, self._callback(topic, kind, what))

    def take(self, timeout: float) -> RgbdFrame | None:
        """The frame that has waited longest, or None.

        Args:
            timeout: Maximum time to wait [s].
        """
        with self._condition:
            self._condition.wait_for(lambda: bool(self._queue), timeout)
            return self._queue.popleft() if self._queue else None

    def clear(self) -> None:
        """Drop all waiting frames and images."""
        with self._message_lock:
            self._assembly.drop_pending()
            with self._condition:
                self._queue.clear()

    @property
    def odom_frame(self) -> str:
        """Frame of the odometry, from its messages or else from the settings."""
        return self._assembly.odom_frame or self._settings.odom_frame

    def missing(self) -> str | None:
        """Description of missing input with the remedy; None if complete."""
        health, depth, info = self._health, self._topics.depth, self._topics.info
        if health.is_silent("depth"):
            if policy := self._middleware.incompatible(depth):
                return self._incompatible_qos("depth images", depth, policy)
            count = self._middleware.publishers(depth)
            if count:
                publishers = f"{count} publisher{'s' * (count > 1)}"
                return f"no recent depth image on {depth}, which has {publishers}"
            return f"nobody publishes depth images on {depth}; choose the topic with --depth"
        if info is not None and not health.count("camera info") and health.count("depth") > 1:
            if policy := self._middleware.incompatible(info):
                return self._incompatible_qos("CameraInfo", info, policy)
            return f"no CameraInfo on {info}; choose its topic with --info, or give --intrinsics"
        if not self._has_pose:
            return self._no_pose()
        return None

    def odometry_error(self) -> str:
        """Why published odometry is not received; "" if it can be."""
        topic = self._topics.odometry
        if topic is None or not (policy := self._middleware.incompatible(topic)):
            return ""
        return self._incompatible_qos("odometry", topic, policy)

    def _incompatible_qos(self, what: str, topic: str, policy: str) -> str:
        """Explanation of an incompatible quality of service, with the remedy."""
        remedy = f"change the {policy} of the publisher"
        if policy == "reliability" and self._settings.reliable:
            remedy = "omit --reliable"
        return (
            f"{what} are published on {topic} with an incompatible quality of service "
            f"({policy}); {remedy}"
        )

    def _no_pose(self) -> str:
        s = self._settings
        if s.poses == "given":
            return (
                f"no transforms link {s.map_frame} to the camera's frame at the time of the "
                "images: no pose is given"
            )
        return (
            f"no transforms link {s.base_frame} to the camera's frame: its mount is "
            "unknown; give --mount X Y Z PAN TILT"
        )

    def _callback(self, topic: str, kind: str, what: str) -> Callable[[bytes], None]:
        def on_message(data: bytes) -> None:
            # A latched publisher matches both subscriptions.
            if kind in (CAMERA_INFO, TRANSFORMS) and self._last.get(topic) == data:
                return
            self._last[topic] = data if kind in (CAMERA_INFO, TRANSFORMS) else b""
            self._health.on_message(what)
            if topic == self._topics.depth and not self._is_due():
                return
            try:
                msg = deserialized(kind, data)
                if kind == IMAGE and msg.height * msg.width > MAX_PIXELS:
                    raise InputError(f"a depth image of {msg.width} x {msg.height} pixels")
                if kind in (IMAGE, ODOMETRY):
                    self._stamp(topic, msg)
                with self._message_lock:
                    # A node that was stopped meanwhile has published its last answer.
                    if topic == self._topics.depth and not self.taking:
                        return
                    self._assemble(BagMessage(topic, round(1e9 * self._clock()), msg))
            except InputError as error:
                self._health.report_error(str(error))
                _log.warning("%s: %s", topic, error)
            except Exception:  # one message must not stop the thread
                self._health.report_error("internal error; see the log")
                _log.exception("%s: a message could not be processed", topic)

        return on_message

    def _stamp(self, topic: str, msg: Any) -> None:
        """Set the time of arrival as stamp if the publisher sets none.

        In simulation, time starts at zero too: a single zero stamp is accepted.
        """
        if nanoseconds_of(msg.header):
            self._zero_stamps.pop(topic, None)
            return
        self._zero_stamps[topic] = self._zero_stamps.get(topic, 0) + 1
        if self._zero_stamps[topic] == 1:
            return
        if self._zero_stamps[topic] == 2:
            # Data received with the first zero stamp have no valid time.
            self._restart()
        set_nanoseconds(msg.header, round(self._wall_clock() * NANOSECONDS))
        error = f"stamps on {topic} are zero; the time of arrival is used"
        self._health.report_error(error)
        _log.warning("%s", error)

    def _is_due(self) -> bool:
        """Whether a depth image is to be processed, according to the rate."""
        now = self._clock()
        if not self.taking or now < self._due:
            return False
        self._due = now + (
            MIN_INTERVAL_FRACTION / self._settings.rate if self._settings.rate else 0.0
        )
        return True

    def _assemble(self, message: BagMessage) -> None:
        try:
            for frame in self._assembly.on_message(message):
                self._enqueue(frame)
        except ClockError as error:
            self._health.report_error(f"the clock jumped by {error.jump_s:+.1f} s")
            _log.warning("the clock jumped by %+.1f s", error.jump_s)
            if error.jump_s < 0:
                self._restart()
            else:
                self._assembly.restart()

    def _restart(self) -> None:
        """Change to another clock: earlier frames belong to another time."""
        with self._message_lock:
            self._assembly.restart()
            self.clear()
            self.backward_jumps += 1

    def _enqueue(self, frame: RgbdFrame) -> None:
        """Queue a frame that has a pose or mount."""
        given = self._settings.poses == "given"
        self._has_pose = (frame.T_map_camera if given else frame.T_base_camera) is not None
        if not self._has_pose:
            self._health.report_error("no transforms give the camera's mount or pose")
            _log.warning("frame skipped: %s", self._no_pose())
            return
        with self._condition:
            if len(self._queue) >= self._settings.queue:
                self._queue.popleft()
                self._health.on_drop()
                _log.warning("frames arrive faster than they are processed: the oldest is dropped")
            self._health.on_frame(frame.odometry is not None or given)
            self._queue.append(frame)
            self._condition.notify()


class _SkippedReasons(MutableMapping[str, str]):
    """Reports reasons to the health instead of storing them."""

    def __init__(self, health: Health) -> None:
        self._health = health

    def __setitem__(self, name: str, reason: str) -> None:
        self._health.report_error(reason)

    def __getitem__(self, name: str) -> str:
        raise KeyError(name)

    def __delitem__(self, name: str) -> None:
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0


def _assembly_settings(settings: NodeSettings) -> AssemblySettings:
    """Settings for the frame assembly."""
    import numpy as np

    camera = mount = None
    if settings.intrinsics:
        width, height = (int(side) for side in settings.size)
        camera = PinholeCamera(width, height, *settings.intrinsics)
    if settings.mount:
        pan, tilt = np.radians(settings.mount[3:])
        mount = looking(settings.mount[:3], float(pan), float(tilt))
    return AssemblySettings(
        camera=camera,
        T_base_camera=mount,
        map_frame=settings.map_frame if settings.poses == "given" else None,
        odom_frame=settings.odom_frame if settings.poses == "found" else None,
        base_frame=settings.base_frame,
    )
