"""Bags of any format as streams of messages that are never loaded as a whole."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Topic:
    """A topic of a bag.

    Attributes:
        name: For example /odom.
        kind: Message type, for example nav_msgs/msg/Odometry.
        count: Number of messages.
        first, last: Log times of the first and last message [ns]; for a bag with an index, of the
            first and last message of all topics. None if unknown.
    """

    name: str
    kind: str
    count: int
    first: int | None = None
    last: int | None = None


@dataclass(frozen=True)
class BagMessage:
    """A message of a bag.

    Attributes:
        topic: Topic it was published on.
        log_time: Time it was recorded [ns].
        msg: The decoded message.
    """

    topic: str
    log_time: int
    msg: Any


class Bag(ABC):
    """A recording of messages; its file is open only while it is being read.

    Attributes:
        path: The file or folder.
        kind: Name of its format.
        topics: Topics by name.
        notes: Metadata that the recorder stored with the messages.
        error: Why reading ended before the end of the bag; None if it did not.
        damage: Description of the damaged parts that were skipped; None if there are none.
        undecoded: Number of messages of the last read that could not be decoded, by topic and type.
    """

    path: Path
    kind: str
    topics: dict[str, Topic]
    notes: dict[str, str]
    error: str | None
    damage: str | None
    undecoded: Counter[tuple[str, str]]

    @abstractmethod
    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """Iterate over the messages of some topics in the order they were recorded.

        Messages that cannot be decoded are skipped and counted.

        Raises:
            InputError: The bag cannot be opened, or a topic does not hold ROS messages.
        """

    @property
    def left_out(self) -> dict[str, str]:
        """What is missing from the messages of the last read, each with the reason."""
        reasons = {
            f"messages on {topic}": f"{count} {'is' if count == 1 else 'are'} not of type {kind}"
            for (topic, kind), count in sorted(self.undecoded.items())
        }
        if self.damage is not None:
            reasons["damaged parts"] = self.damage
        return reasons if self.error is None else {**reasons, "the end": self.error}
