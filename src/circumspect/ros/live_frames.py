"""Frames, put together of messages while they come."""

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
    TRANSFORMS_HEARD,
    Middleware,
    Quality,
)
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.wire_messages import unpacked
from circumspect.sensing import RgbdFrame
from circumspect.sensing.viewing import looking

TF, TF_STATIC = "/tf", "/tf_static"
MOST_PIXELS = 4_000_000
"""Larger depth images are left out: no depth camera makes them."""
EARLY = 0.9
"""A frame is due after this share of the time between two, for cameras are not quite even."""

_log = logging.getLogger(__name__)


class LiveFrames:
    """Hears what a robot publishes; frames wait in a queue that lets the oldest go."""

    def __init__(
        self,
        middleware: Middleware,
        settings: NodeSettings,
        health: Health,
        clock: Callable[[], float] = time.monotonic,
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        """Subscribe.

        Args:
            middleware: Carries the messages.
            settings: Of the node.
            health: Is told what comes and what is left out.
            clock: Gives the time of arrival [s].
            wall_clock: Stamps messages whose publisher does not [s].

        Raises:
            InputError: The middleware refuses a topic.
        """
        self.taking = False
        """Whether depth images are worked on."""
        self.leaps_back = 0
        """How often the stamps leapt back: what was seen before belongs to another time."""
        self._settings, self._health, self._clock = settings, health, clock
        self._condition = threading.Condition()
        self._hearing = threading.RLock()
        self._queue: deque[RgbdFrame] = deque()
        self._due = -float("inf")
        self._wall_clock = wall_clock
        self._zeros: dict[str, int] = {}
        """Topic to how many of its last messages in a row had a stamp of zero."""
        self._last: dict[str, bytes] = {}
        """The last message of topics that have several subscriptions."""
        self._mounted = True
        self._topics = ChosenTopics(
            settings.depth_topic, settings.info_topic, None, settings.odometry_topic,
            (TF, TF_STATIC),
        )  # fmt: skip
        self._assembly = FrameAssembly(self._topics, _assembled(settings), _LeftOut(health))
        self._middleware = middleware
        self._subscribe_all()

    def _subscribe_all(self) -> None:
        sensor = replace(SENSOR, reliable=self._settings.reliable)
        # Each quality that may be offered needs a subscription of its own.
        wanted: list[tuple[str | None, str, Quality, str]] = [
            (TF_STATIC, TRANSFORMS, STATIC_TRANSFORMS_VOLATILE, "static transforms"),
            (self._topics.info, CAMERA_INFO, CAMERA_INFO_LATCHED, "camera info"),
            (TF_STATIC, TRANSFORMS, STATIC_TRANSFORMS, "static transforms"),
            (TF, TRANSFORMS, TRANSFORMS_HEARD, "transforms"),
            (self._topics.info, CAMERA_INFO, sensor, "camera info"),
            (self._topics.odometry, ODOMETRY, sensor, "odometry"),
            (self._topics.depth, IMAGE, sensor, "depth"),
        ]
        for topic, kind, quality, what in wanted:
            if topic is not None:
                self._middleware.subscribe(topic, kind, quality, self._hearer(topic, kind, what))

    def take(self, timeout: float) -> RgbdFrame | None:
        """The frame that has waited longest.

        Args:
            timeout: So long one is waited for [s].
        """
        with self._condition:
            self._condition.wait_for(lambda: bool(self._queue), timeout)
            return self._queue.popleft() if self._queue else None

    def clear(self) -> None:
        """Let go of the frames that wait, for their turn or for their odometry."""
        with self._hearing:
            self._assembly.let_go()
            with self._condition:
                self._queue.clear()

    @property
    def odom_frame(self) -> str:
        """The frame of the odometry: as its messages call it, or else as the settings do."""
        return self._assembly.odom_frame or self._settings.odom_frame

    def missing(self) -> str | None:
        """What the frames lack, in words with the remedy; None where all is there."""
        health, depth, info = self._health, self._topics.depth, self._topics.info
        if health.silent("depth"):
            if policy := self._middleware.incompatible(depth):
                return self._unheard("depth images", depth, policy)
            there = self._middleware.publishers(depth)
            if there:
                return f"no depth image came lately on {depth}, which {there} publish"
            return f"nobody publishes depth images on {depth}; name the topic by --depth"
        if info is not None and not health.count("camera info") and health.count("depth") > 1:
            if policy := self._middleware.incompatible(info):
                return self._unheard("CameraInfo", info, policy)
            return f"no CameraInfo on {info}; name its topic by --info or give --intrinsics"
        if not self._mounted:
            return self._no_pose()
        return None

    def odometry_fault(self) -> str:
        """Why no odometry is received although it is published; "" where it can."""
        topic = self._topics.odometry
        if topic is None or not (policy := self._middleware.incompatible(topic)):
            return ""
        return self._unheard("odometry", topic, policy)

    def _unheard(self, what: str, topic: str, policy: str) -> str:
        """That quality of service keeps messages away, with the remedy."""
        remedy = f"let the publisher offer another {policy}"
        if policy == "reliability" and self._settings.reliable:
            remedy = "leave --reliable out"
        return (
            f"{what} are published on {topic} with an incompatible quality of service "
            f"({policy}); {remedy}"
        )

    def _no_pose(self) -> str:
        s = self._settings
        if s.poses == "given":
            return (
                f"no transforms link {s.map_frame} to the camera's frame at the images' time: no "
                "pose is given"
            )
        return (
            f"no transforms link {s.base_frame} to the camera's frame: nothing tells where it is "
            "mounted; give --mount X Y Z PAN TILT"
        )

    def _hearer(self, topic: str, kind: str, what: str) -> Callable[[bytes], None]:
        def heard(data: bytes) -> None:
            # A publisher that keeps its messages matches both subscriptions.
            if kind in (CAMERA_INFO, TRANSFORMS) and self._last.get(topic) == data:
                return
            self._last[topic] = data if kind in (CAMERA_INFO, TRANSFORMS) else b""
            self._health.message(what)
            if topic == self._topics.depth and not self._is_due():
                return
            try:
                told = unpacked(kind, data)
                if kind == IMAGE and told.height * told.width > MOST_PIXELS:
                    raise InputError(f"a depth image of {told.width} x {told.height} pixels")
                if kind in (IMAGE, ODOMETRY):
                    self._stamp(topic, told)
                with self._hearing:
                    # Whoever stopped the node meanwhile has its last answer already.
                    if topic == self._topics.depth and not self.taking:
                        return
                    self._assemble(BagMessage(topic, round(1e9 * self._clock()), told))
            except InputError as error:
                self._health.fault(str(error))
                _log.warning("%s: %s", topic, error)
            except Exception:  # one message must not make the node deaf
                self._health.fault("a fault inside; see the log")
                _log.exception("%s: a message could not be worked on", topic)

        return heard

    def _stamp(self, topic: str, told: Any) -> None:
        """Take the time of arrival where a publisher sets no stamps.

        Simulated time begins at zero, too: one message without a stamp says nothing yet.
        """
        if nanoseconds_of(told.header):
            self._zeros.pop(topic, None)
            return
        self._zeros[topic] = self._zeros.get(topic, 0) + 1
        if self._zeros[topic] == 1:
            return
        if self._zeros[topic] == 2:
            # What came with the first one belongs to no time.
            self._restart()
        set_nanoseconds(told.header, round(self._wall_clock() * NANOSECONDS))
        fault = f"stamps on {topic} are zero; the time of arrival is used"
        self._health.fault(fault)
        _log.warning("%s", fault)

    def _is_due(self) -> bool:
        """Whether a depth image is one of those that are taken."""
        now = self._clock()
        if not self.taking or now < self._due:
            return False
        self._due = now + (EARLY / self._settings.rate if self._settings.rate else 0.0)
        return True

    def _assemble(self, message: BagMessage) -> None:
        try:
            for frame in self._assembly.heard(message):
                self._offer(frame)
        except ClockError as error:
            self._health.fault(f"the clock leapt by {error.leap:+.1f} s")
            _log.warning("the clock leapt by %+.1f s", error.leap)
            if error.leap < 0:
                self._restart()
            else:
                self._assembly.restart()

    def _restart(self) -> None:
        """Go on with another clock: what was seen before belongs to another time."""
        with self._hearing:
            self._assembly.restart()
            self.clear()
            self.leaps_back += 1

    def _offer(self, frame: RgbdFrame) -> None:
        """Queue a frame that says where the camera is."""
        given = self._settings.poses == "given"
        self._mounted = (frame.T_map_camera if given else frame.T_base_camera) is not None
        if not self._mounted:
            self._health.fault("no transforms tell where the camera is")
            _log.warning("a frame left out: %s", self._no_pose())
            return
        with self._condition:
            if len(self._queue) >= self._settings.queue:
                self._queue.popleft()
                self._health.drop()
                _log.warning("frames come faster than they are worked on: the oldest is dropped")
            self._health.frame(frame.odometry is not None or given)
            self._queue.append(frame)
            self._condition.notify()


class _LeftOut(MutableMapping[str, str]):
    """Hands reasons on to the health instead of keeping them."""

    def __init__(self, health: Health) -> None:
        self._health = health

    def __setitem__(self, name: str, reason: str) -> None:
        self._health.fault(reason)

    def __getitem__(self, name: str) -> str:
        raise KeyError(name)

    def __delitem__(self, name: str) -> None:
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0


def _assembled(settings: NodeSettings) -> AssemblySettings:
    """What the messages do not tell."""
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
