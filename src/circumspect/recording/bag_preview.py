"""The part of a bag that is read before its frames: camera, static transforms, clocks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from circumspect.errors import CircumspectError, InputError
from circumspect.recording.bag import Bag
from circumspect.recording.image_messages import camera_of
from circumspect.recording.message_clocks import ClockSamples, MessageClocks
from circumspect.recording.topic_choice import ChosenTopics

STATIC_SUFFIX = "tf_static"
"""Last word of the names of topics with static transforms."""
MAX_FRAMES = 5000
"""Limit of the number of coordinate frames."""


@dataclass
class BagPreview:
    """Data that hold for a whole bag, wherever in the bag they were recorded.

    CameraInfo and static transforms hold for all images: a driver may publish them only once, and a
    recorder may receive them late.

    Attributes:
        info: The first usable CameraInfo; None if none is needed.
        static: The first transform of each frame on a static topic.
        clocks: Corrections of time stamps.
    """

    info: Any = None
    static: list[Any] = field(default_factory=list)
    clocks: MessageClocks = field(default_factory=MessageClocks)


def preview(bag: Bag, topics: ChosenTopics, needs_info: bool) -> BagPreview:
    """Read a bag until all data that hold for the whole bag are known, usually its first second.

    Args:
        bag: The messages.
        topics: The chosen topics.
        needs_info: Whether a CameraInfo is required.

    Raises:
        InputError: The bag has CameraInfo messages, but none is usable.
    """
    scan = _Scan(bag, topics, needs_info)
    for message in bag.messages(scan.wanted):
        scan.take(message)
        if scan.is_complete:
            break
    if needs_info and scan.found.info is None:
        raise InputError(
            f"{bag.path}: {topics.info}: {scan.error or 'holds no readable CameraInfo'}; "
            "name another topic with --info-topic, or give --intrinsics FX FY CX CY"
        )
    clocks = MessageClocks.from_samples(scan.samples, topics.depth, str(bag.path))
    return BagPreview(scan.found.info, scan.found.static, clocks)


class _Scan:
    """State of the preview: what has been read so far."""

    def __init__(self, bag: Bag, topics: ChosenTopics, needs_info: bool) -> None:
        self.found, self.samples, self.error = BagPreview(), ClockSamples(), ""
        self._bag, self._topics, self._needs_info = bag, topics, needs_info
        self._counts: dict[str, int] = {}
        self._frames: set[str] = set()
        self._static = {name for name in topics.transforms if name.endswith(STATIC_SUFFIX)}
        single = (topics.depth, topics.colour, topics.odometry)
        self._clocked = {name for name in single if name} | set(topics.transforms) - self._static
        info = {topics.info} if needs_info and topics.info else set()
        self.wanted = self._static | self._clocked | info

    def take(self, message: Any) -> None:
        topic = message.topic
        self._counts[topic] = self._counts.get(topic, 0) + 1
        if topic in self._clocked:
            self.samples.add(message)
        elif topic in self._static:
            self._take_static(message.msg)
        elif self.found.info is None:
            try:
                camera_of(message.msg)
                self.found.info = message.msg
            except CircumspectError as error:
                self.error = str(error)

    def _take_static(self, msg: Any) -> None:
        for stamped in msg.transforms:
            if stamped.child_frame_id not in self._frames and len(self._frames) < MAX_FRAMES:
                self._frames.add(stamped.child_frame_id)
                self.found.static.append(stamped)

    @property
    def is_complete(self) -> bool:
        if self._needs_info and self.found.info is None:
            return False
        if not all(self._is_read(topic) for topic in self._static):
            return False
        return all(self.samples.is_complete(t) or self._is_read(t) for t in self._clocked)

    def _is_read(self, topic: str) -> bool:
        """Whether all messages of a topic have been read."""
        return self._counts.get(topic, 0) >= self._bag.topics[topic].count
