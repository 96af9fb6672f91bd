"""The interface of everything that carries messages: DDS itself, or rclpy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

Heard = Callable[[bytes], None]
"""Is given each message as it went over the wire: CDR with its encapsulation header."""


@dataclass(frozen=True)
class Quality:
    """Quality of service, as far as it is chosen here.

    Attributes:
        reliable: What is lost is sent again.
        latched: Who comes late gets what was sent last ("transient local").
        depth: So many messages are kept.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = 10


SENSOR = Quality(reliable=False, depth=30)
"""ROS 2's profile for sensor data, which hears best effort and reliable publishers, but deeper:
on a busy robot the receiving thread may have to wait, and a camera has 30 images a second."""
TRANSFORMS_HEARD = Quality(reliable=False, depth=100)
STATIC_TRANSFORMS = Quality(latched=True, depth=100)
STATIC_TRANSFORMS_VOLATILE = Quality(reliable=False, depth=100)
"""A publisher that does not keep its static transforms for latecomers matches nothing else."""
CAMERA_INFO_LATCHED = Quality(latched=True, depth=1)
"""Some drivers publish CameraInfo once and keep it for latecomers."""
COMMANDS = Quality()
LATEST = Quality(latched=True, depth=1)
ANSWERS = Quality(latched=True, depth=10)
REPORTS = Quality()


class Middleware(ABC):
    """Carries packed messages of ROS 2; topic names are absolute."""

    @abstractmethod
    def subscribe(self, topic: str, kind: str, quality: Quality, heard: Heard) -> None:
        """Hear a topic.

        Args:
            topic: Such as "/odom".
            kind: Its type, such as "nav_msgs/msg/Odometry".
            quality: What is asked of publishers.
            heard: Called with every message, in a thread of the middleware, one at a time.

        Raises:
            InputError: The middleware refuses.
        """

    @abstractmethod
    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        """Offer a topic.

        Args:
            topic: Such as "/circumspect/model".
            kind: Its type.
            quality: What is promised to subscribers.

        Returns:
            Publishes a packed message; may be called from any thread.

        Raises:
            InputError: The middleware refuses.
        """

    @abstractmethod
    def publishers(self, topic: str) -> int:
        """How many publishers match the subscriptions to a topic."""

    def incompatible(self, topic: str) -> str:
        """The policy of quality of service that no publisher of a topic meets.

        Args:
            topic: One that is subscribed to; perhaps with several qualities.

        Returns:
            "reliability", "durability" or another quality of service; "" where somebody can be
            heard, nobody publishes, or the middleware does not say it.
        """
        del topic
        return ""

    @property
    @abstractmethod
    def lost(self) -> int:
        """Messages that went missing on the wire, as far as that is noticed."""

    @abstractmethod
    def close(self) -> None:
        """Leave the network; nothing is heard any more when this returns."""
