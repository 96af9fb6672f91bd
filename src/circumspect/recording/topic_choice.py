"""Choice of the topics of a bag that hold the robot's data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circumspect.errors import InputError
from circumspect.recording.bag import Bag, Topic
from circumspect.recording.ros_types import (
    CAMERA_INFO,
    COMPRESSED_IMAGE,
    IMAGE,
    ODOMETRY,
    TRANSFORMS,
)

COMPRESSED = "/compressedDepth"
PREFERRED_ENDINGS = ("image_rect_raw", "image_rect", "image_raw", "image")
"""Last words of the names of depth topics, in order of preference; rectified images come first."""


@dataclass(frozen=True)
class TopicNames:
    """Topics by name; None means that the topic is guessed.

    Attributes:
        depth: Depth images.
        info: CameraInfo of the depth camera.
        colour: Colour images registered to the depth images.
        odometry: Wheel odometry; "" for none.
    """

    depth: str | None = None
    info: str | None = None
    colour: str | None = None
    odometry: str | None = None


@dataclass(frozen=True)
class ChosenTopics:
    """The topics chosen from a bag.

    Attributes:
        depth: Depth images.
        info: Their CameraInfo, or None.
        colour: Colour images, or None.
        odometry: Wheel odometry, or None.
        transforms: All topics with transforms.
    """

    depth: str
    info: str | None
    colour: str | None
    odometry: str | None
    transforms: tuple[str, ...]

    @property
    def all(self) -> set[str]:
        """All chosen topics."""
        single = (self.depth, self.info, self.colour, self.odometry)
        return {name for name in (*single, *self.transforms) if name is not None}


def choose_topics(bag: Bag, wanted: TopicNames) -> ChosenTopics:
    """Choose the requested topics, and guess the others.

    Raises:
        InputError: A requested topic is missing or has another type; there is no depth topic; or
            several topics are equally likely.
    """
    images = (IMAGE, COMPRESSED_IMAGE)
    depth = _named(bag, wanted.depth, "--depth-topic", *images) or _depth_topic(bag)
    space = depth.removesuffix(COMPRESSED).removesuffix("/compressed").rsplit("/", 1)[0]
    info = _named(bag, wanted.info, "--info-topic", CAMERA_INFO)
    info = info or _nearest_info(_of_kind(bag.topics, CAMERA_INFO), space, depth)
    odometry = None
    if wanted.odometry != "":
        odometry = _named(bag, wanted.odometry, "--odometry-topic", ODOMETRY)
        odometry = odometry or _odometry(bag)
    transforms = tuple(_of_kind(bag.topics, TRANSFORMS, "tf/tfMessage", "tf/msg/tfMessage"))
    colour = _named(bag, wanted.colour, "--colour-topic", IMAGE, except_topic=depth) or _colour(
        bag, depth
    )
    return ChosenTopics(depth, info, colour, odometry, transforms)


def require_info(bag: Bag, topics: ChosenTopics) -> None:
    """Check that the intrinsics are known.

    Raises:
        InputError: There is no CameraInfo.
    """
    if topics.info is None:
        raise InputError(
            f"{bag.path}: no CameraInfo belongs to {topics.depth}; choose a topic with "
            "--info-topic or give --intrinsics FX FY CX CY"
        )


def _of_kind(topics: Mapping[str, Topic], *kinds: str) -> list[str]:
    return sorted(name for name, topic in topics.items() if topic.kind in kinds)


def _named(
    bag: Bag, name: str | None, flag: str, *kinds: str, except_topic: str = ""
) -> str | None:
    """The requested topic, if it exists and has a suitable type."""
    if name is None:
        return None
    if name not in bag.topics:
        raise InputError(
            f"{bag.path}: contains no {name} ({flag}); topics: {', '.join(sorted(bag.topics))}"
        )
    held = bag.topics[name].kind
    if held not in kinds:
        fitting = [topic for topic in _of_kind(bag.topics, *kinds) if topic != except_topic]
        raise InputError(
            f"{bag.path}: {name} ({flag}) holds {held or 'several types'}, not "
            f"{' or '.join(kinds)}; {', '.join(fitting) or 'no topic'} has such a type"
        )
    return name


def _depth_topic(bag: Bag) -> str:
    images = _of_kind(bag.topics, IMAGE, COMPRESSED_IMAGE)
    depths = [
        n for n in images if "depth" in n.lower() and not n.endswith(("/compressed", "/theora"))
    ]
    plain = [name for name in depths if bag.topics[name].kind == IMAGE] or depths
    for word in PREFERRED_ENDINGS:
        preferred = [name for name in plain if name.endswith(word)]
        if preferred:
            plain = preferred
            break
    if len(plain) == 1:
        return plain[0]
    if plain:
        raise InputError(
            f"{bag.path}: several topics may hold the depth: {', '.join(plain)}; choose one with "
            "--depth-topic"
        )
    raise InputError(
        f"{bag.path}: no topic holds depth images; topics: {', '.join(sorted(bag.topics))}; "
        "choose one with --depth-topic"
    )


def _nearest_info(infos: list[str], space: str, depth: str) -> str | None:
    """The CameraInfo in the namespace of the images or of their topic."""
    if f"{space}/camera_info" in infos:
        return f"{space}/camera_info"
    near = [name for name in infos if name.rsplit("/", 1)[0] in (space, depth)]
    return near[0] if len(near) == 1 else None


def _odometry(bag: Bag) -> str | None:
    found = _of_kind(bag.topics, ODOMETRY)
    if len(found) > 1 and "/odom" in found:
        return "/odom"
    if len(found) > 1:
        raise InputError(
            f"{bag.path}: several topics hold odometry: {', '.join(found)}; choose one with "
            '--odometry-topic, or none with --odometry-topic ""'
        )
    return found[0] if found else None


def _colour(bag: Bag, depth: str) -> str | None:
    images = _of_kind(bag.topics, IMAGE)
    # The name of a depth image registered to the colour image contains both words.
    found = [
        name
        for name in images
        if name != depth
        and ("color" in name.lower() or "rgb" in name.lower())
        and "depth" not in name.lower()
    ]
    return found[0] if len(found) == 1 else None
