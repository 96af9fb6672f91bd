"""Images of ceiling cameras in a bag."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence

from circumspect.errors import InputError
from circumspect.localization import CeilingImage
from circumspect.recording.bag import Bag
from circumspect.recording.image_messages import grey_of
from circumspect.recording.ros_time import seconds
from circumspect.recording.ros_types import COMPRESSED_IMAGE, IMAGE

_log = logging.getLogger(__name__)


class CeilingBag:
    """Images of several ceiling cameras, in the order they were recorded.

    Memory does not grow with the bag. Interchangeable with `ImageFolder`.

    Attributes:
        bag: The messages.
        cameras: Names of the cameras with images in the bag, sorted.
        topics: Topic to camera.
        skipped: Unreadable images so far, with the reason.
    """

    def __init__(
        self, bag: Bag, cameras: Sequence[str], topics: Mapping[str, str] | None = None
    ) -> None:
        """Choose the topics.

        Args:
            bag: The messages.
            cameras: Names of the calibrated cameras.
            topics: Camera to topic. For other cameras it is the image topic with the camera's name
                between slashes, such as /ceiling_0/image_raw.

        Raises:
            InputError: A topic is missing or holds no images; a camera has several topics, or a
                topic several cameras; or no camera has a topic.
        """
        self.bag = bag
        self.skipped: dict[str, str] = {}
        requested = dict(topics or {})
        held = sorted(n for n, t in bag.topics.items() if t.kind in (IMAGE, COMPRESSED_IMAGE))
        shown = ", ".join(held) or "none"
        for camera, topic in requested.items():
            if topic not in held:
                raise InputError(
                    f"{bag.path}: {topic} of {camera} is not an image topic; image topics: {shown}"
                )
        found = {camera: requested.get(camera) or _topic(bag, held, camera) for camera in cameras}
        self.topics = {topic: camera for camera, topic in found.items() if topic is not None}
        for camera, topic in found.items():
            if topic is not None and (other := self.topics[topic]) != camera:
                raise InputError(f"{bag.path}: {topic} is given for both {camera} and {other}")
        self.cameras = tuple(sorted(self.topics.values()))
        if not self.cameras:
            raise InputError(
                f"{bag.path}: no image topic is named after one of the cameras "
                f"{', '.join(cameras)}; image topics: {shown}; choose one with --topic CAMERA=TOPIC"
            )

    def __len__(self) -> int:
        return sum(self.bag.topics[topic].count for topic in self.topics)

    def __iter__(self) -> Iterator[CeilingImage]:
        for message in self.bag.messages(set(self.topics)):
            camera, stamp = self.topics[message.topic], seconds(message.msg)
            try:
                yield CeilingImage(camera, stamp, grey_of(message.msg))
            except InputError as error:
                self.skipped[f"{message.topic} at {stamp:.3f} s"] = str(error)
        for name, reason in self.bag.left_out.items():
            self.skipped[name] = reason
            _log.warning("%s: %s skipped: %s", self.bag.path, name, reason)


def _topic(bag: Bag, held: Sequence[str], camera: str) -> str | None:
    """The topic named after a camera; raw images are preferred to compressed ones."""
    named = [topic for topic in held if camera in topic.split("/")]
    raw = [topic for topic in named if bag.topics[topic].kind == IMAGE] or named
    if len(raw) > 1:
        raise InputError(
            f"{bag.path}: several topics may hold images of {camera}: {', '.join(raw)}; choose "
            f"one with --topic {camera}=TOPIC"
        )
    return raw[0] if raw else None
