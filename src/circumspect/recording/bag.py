"""Messages of a bag, whatever its format, as they come and without loading it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Topic:
    """What a bag holds of a topic.

    Attributes:
        name: Such as /odom.
        kind: Its type, such as nav_msgs/msg/Odometry.
        count: Messages.
        first, last: When the first and the last one were heard [ns]; None where that is not known.
    """

    name: str
    kind: str
    count: int
    first: int | None = None
    last: int | None = None


@dataclass(frozen=True)
class BagMessage:
    """One message.

    Attributes:
        topic: Where it was published.
        log_time: When it was heard [ns].
        told: The message.
    """

    topic: str
    log_time: int
    told: Any


class Bag(ABC):
    """A recording of messages; its file is open only while it is read.

    Attributes:
        path: The file or folder.
        kind: Its format, in words.
        topics: By name.
        notes: What was kept with the messages by whoever recorded them.
        fault: Why reading ended before the bag's end; None while it did not.
    """

    path: Path
    kind: str
    topics: dict[str, Topic]
    notes: dict[str, str]
    fault: str | None

    @abstractmethod
    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """The messages of some topics, in the order in which they were heard.

        Raises:
            InputError: A message can not be read.
        """
