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
    """The images of some cameras, in the order in which they were heard.

    Memory does not grow with the bag. Stands in for `ImageFolder`.

    Attributes:
        bag: The messages.
        cameras: Those whose images it holds, sorted.
        topics: Topic to camera.
        skipped: Images that could not be read so far, with the reason.
    """

    def __init__(
        self, bag: Bag, cameras: Sequence[str], topics: Mapping[str, str] | None = None
    ) -> None:
        """Choose the topics.

        Args:
            bag: The messages.
            cameras: Names of the cameras that are calibrated.
            topics: Camera to topic; for a camera that is not told, the topic of images that has
                the camera's name between slashes, as /ceiling_0/image_raw.

        Raises:
            InputError: A topic that the bag does not hold or that holds no images, several topics
                for a camera, one topic for several, or none for all of them.
        """
        self.bag = bag
        self.skipped: dict[str, str] = {}
        told = dict(topics or {})
        held = sorted(n for n, t in bag.topics.items() if t.kind in (IMAGE, COMPRESSED_IMAGE))
        shown = ", ".join(held) or "none"
        for camera, topic in told.items():
            if topic not in held:
                raise InputError(f"{bag.path}: {topic} of {camera} is no topic of images: {shown}")
        found = {camera: told.get(camera) or _topic(bag, held, camera) for camera in cameras}
        self.topics = {topic: camera for camera, topic in found.items() if topic is not None}
        for camera, topic in found.items():
            if topic is not None and (other := self.topics[topic]) != camera:
                raise InputError(f"{bag.path}: {topic} can not be both {camera}'s and {other}'s")
        self.cameras = tuple(sorted(self.topics.values()))
        if not self.cameras:
            raise InputError(
                f"{bag.path}: no topic of images is named after one of the cameras "
                f"{', '.join(cameras)}; it holds {shown}; say which by --topic CAMERA=TOPIC"
            )

    def __len__(self) -> int:
        return sum(self.bag.topics[topic].count for topic in self.topics)

    def __iter__(self) -> Iterator[CeilingImage]:
        for message in self.bag.messages(set(self.topics)):
            camera, stamp = self.topics[message.topic], seconds(message.told)
            try:
                yield CeilingImage(camera, stamp, grey_of(message.told))
            except InputError as error:
                self.skipped[f"{message.topic} at {stamp:.3f} s"] = str(error)
        for name, reason in self.bag.left_out.items():
            self.skipped[name] = reason
            _log.warning("%s: %s left out: %s", self.bag.path, name, reason)


def _topic(bag: Bag, held: Sequence[str], camera: str) -> str | None:
    """The topic named after a camera; of the same images raw ones rather than compressed ones."""
    named = [topic for topic in held if camera in topic.split("/")]
    raw = [topic for topic in named if bag.topics[topic].kind == IMAGE] or named
    if len(raw) > 1:
        raise InputError(
            f"{bag.path}: several topics may hold images of {camera}: {', '.join(raw)}; choose "
            f"one by --topic {camera}=TOPIC"
        )
    return raw[0] if raw else None
