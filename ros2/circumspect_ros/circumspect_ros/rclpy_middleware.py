"""Transport of serialized messages over rclpy instead of DDS."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_policy_name_from_kind,
)
from rosidl_runtime_py.utilities import get_message

try:
    from rclpy.event_handler import SubscriptionEventCallbacks
except ImportError:  # Humble
    from rclpy.qos_event import SubscriptionEventCallbacks

from circumspect.ros.middleware import MessageCallback, Middleware, Quality


class RclpyMiddleware(Middleware):
    """Subscriptions and publishers of one rclpy node, and the thread that serves them."""

    def __init__(self, node: Any) -> None:
        """Start to serve a node.

        Args:
            node: A `rclpy.node.Node`; `close` destroys it.
        """
        self._node = node
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._incompatible: dict[str, list[str]] = {}
        """Topic to the incompatible policy of each subscription; "" if compatible."""
        self._is_open = True
        self._thread = threading.Thread(target=self._serve, name="rclpy", daemon=True)
        self._thread.start()

    def subscribe(self, topic: str, kind: str, quality: Quality, callback: MessageCallback) -> None:
        """See `Middleware.subscribe`."""
        policies = self._incompatible.setdefault(topic, [])
        number = len(policies)
        policies.append("")

        def on_incompatible(event: Any) -> None:
            name = qos_policy_name_from_kind(event.last_policy_kind)
            policies[number] = str(name).removesuffix("_QOS_POLICY").lower()

        self._node.create_subscription(
            get_message(kind), topic, callback, profile(quality), raw=True,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=on_incompatible),
        )  # fmt: skip

    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        """See `Middleware.advertise`."""
        publisher = self._node.create_publisher(get_message(kind), topic, profile(quality))

        def publish(data: bytes) -> None:
            if self._is_open:
                publisher.publish(data)  # rclpy accepts serialized messages as bytes

        return publish

    def publishers(self, topic: str) -> int:
        """See `Middleware.publishers`."""
        return self._node.count_publishers(topic)

    def incompatible(self, topic: str) -> str:
        """See `Middleware.incompatible`."""
        policies = self._incompatible.get(topic, [])
        return policies[-1] if policies and all(policies) else ""

    @property
    def lost(self) -> int:
        """Always 0: not every middleware below rclpy reports it."""
        return 0

    def close(self) -> None:
        """See `Middleware.close`."""
        if not self._is_open:
            return
        self._is_open = False
        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()

    def _serve(self) -> None:
        with suppress(ExternalShutdownException):  # the usual end
            self._executor.spin()


def profile(quality: Quality) -> QoSProfile:
    """The rclpy profile of a quality of service."""
    reliable, latched = quality.reliable, quality.latched
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=quality.depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
