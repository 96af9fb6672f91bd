"""Messages over rclpy instead of over DDS directly; they stay packed on the way."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosidl_runtime_py.utilities import get_message

from circumspect.ros.middleware import Heard, Middleware, Quality


class RclpyMiddleware(Middleware):
    """Subscriptions and publishers of one rclpy node, and the thread that serves them."""

    def __init__(self, node: Any) -> None:
        """Begin to serve a node.

        Args:
            node: A `rclpy.node.Node`; is destroyed by `close`.
        """
        self._node = node
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._going = True
        self._thread = threading.Thread(target=self._serve, name="rclpy", daemon=True)
        self._thread.start()

    def subscribe(self, topic: str, kind: str, quality: Quality, heard: Heard) -> None:
        """See `Middleware.subscribe`."""
        self._node.create_subscription(get_message(kind), topic, heard, profile(quality), raw=True)

    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        """See `Middleware.advertise`."""
        publisher = self._node.create_publisher(get_message(kind), topic, profile(quality))

        def publish(data: bytes) -> None:
            if self._going:
                publisher.publish(data)  # rclpy takes packed messages as bytes

        return publish

    def publishers(self, topic: str) -> int:
        """See `Middleware.publishers`."""
        return self._node.count_publishers(topic)

    @property
    def lost(self) -> int:
        """Always 0: not every middleware below rclpy tells it."""
        return 0

    def close(self) -> None:
        """See `Middleware.close`."""
        if not self._going:
            return
        self._going = False
        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()

    def _serve(self) -> None:
        with suppress(ExternalShutdownException):  # the usual end
            self._executor.spin()


def profile(quality: Quality) -> QoSProfile:
    """A quality of service in rclpy's words."""
    reliable, latched = quality.reliable, quality.latched
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=quality.depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
