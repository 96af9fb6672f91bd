"""Messages of a bag, whatever its format, as they come and without loading it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
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
        first, last: When the first and the last one were heard [ns]; of a bag with an index, when
            the first and the last message of all topics were. None where nothing tells.
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
        damage: What was damaged in the bag and left out, and how much of it; None for nothing.
        undecoded: How many messages read last are not what they should be, by topic and type.
    """

    path: Path
    kind: str
    topics: dict[str, Topic]
    notes: dict[str, str]
    fault: str | None
    damage: str | None
    undecoded: Counter[tuple[str, str]]

    @abstractmethod
    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """The messages of some topics, in the order in which they were heard.

        One that can not be decoded is left out and counted.

        Raises:
            InputError: The bag can not be opened, or a topic holds no messages of ROS.
        """

    @property
    def left_out(self) -> dict[str, str]:
        """What is missing among the messages read last, each with the reason."""
        told = {
            f"messages on {topic}": f"{count} {'is' if count == 1 else 'are'} no {kind}"
            for (topic, kind), count in sorted(self.undecoded.items())
        }
        if self.damage is not None:
            told["what is damaged"] = self.damage
        return told if self.fault is None else {**told, "the end": self.fault}
