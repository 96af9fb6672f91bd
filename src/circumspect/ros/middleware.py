"""Interface of the message transport: DDS or rclpy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

MessageCallback = Callable[[bytes], None]
"""Receives each serialized message: CDR with its encapsulation header."""


@dataclass(frozen=True)
class Quality:
    """Quality of service of a subscription or publisher.

    Attributes:
        reliable: Lost messages are sent again.
        latched: Late subscribers receive the last messages ("transient local").
        depth: Number of messages that are kept.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = 10


SENSOR = Quality(reliable=False, depth=30)
"""ROS 2's sensor data profile, compatible with best-effort and reliable publishers, but deeper:
on a busy robot the receiving thread may have to wait, and a camera sends 30 images per second."""
TRANSFORMS_QUALITY = Quality(reliable=False, depth=100)
STATIC_TRANSFORMS = Quality(latched=True, depth=100)
STATIC_TRANSFORMS_VOLATILE = Quality(reliable=False, depth=100)
"""The only profile that matches publishers whose static transforms are not latched."""
CAMERA_INFO_LATCHED = Quality(latched=True, depth=1)
"""Some drivers publish CameraInfo only once, latched."""
COMMANDS = Quality()
LATEST = Quality(latched=True, depth=1)
ANSWERS = Quality(latched=True, depth=10)
REPORTS = Quality()


class Middleware(ABC):
    """Transport of serialized ROS 2 messages; topic names are absolute."""

    @abstractmethod
    def subscribe(self, topic: str, kind: str, quality: Quality, callback: MessageCallback) -> None:
        """Subscribe to a topic.

        Args:
            topic: Topic, such as "/odom".
            kind: Message type, such as "nav_msgs/msg/Odometry".
            quality: Requested quality of service.
            callback: Called with every message, one at a time, in a thread of the middleware.

        Raises:
            InputError: The middleware rejects the topic.
        """

    @abstractmethod
    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        """Advertise a topic.

        Args:
            topic: Topic, such as "/circumspect/model".
            kind: Message type.
            quality: Offered quality of service.

        Returns:
            A thread-safe function that publishes a serialized message.

        Raises:
            InputError: The middleware rejects the topic.
        """

    @abstractmethod
    def publishers(self, topic: str) -> int:
        """Number of publishers that match the subscriptions to a topic."""

    def incompatible(self, topic: str) -> str:
        """The quality of service policy that no publisher of a topic meets.

        Args:
            topic: A subscribed topic.

        Returns:
            "reliability", "durability" or another policy; "" if a publisher matches, there is none,
            or the policy is unknown.
        """
        del topic
        return ""

    @property
    @abstractmethod
    def lost(self) -> int:
        """Number of messages lost in transport, as far as known."""

    @abstractmethod
    def close(self) -> None:
        """Leave the network; no callback is called after this returns."""
