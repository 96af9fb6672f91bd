"""Which topics of a bag hold what a robot sees."""

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
USUAL = ("image_rect_raw", "image_rect", "image_raw", "image")
"""Last words of the names of depth topics, the likeliest first: rectified ones are of use as they
are."""


@dataclass(frozen=True)
class TopicNames:
    """Topics by name; None means that they are guessed.

    Attributes:
        depth: Depth images.
        info: The depth camera's CameraInfo.
        colour: Colour images that lie on the depth images.
        odometry: The wheels'; "" for none.
    """

    depth: str | None = None
    info: str | None = None
    colour: str | None = None
    odometry: str | None = None


@dataclass(frozen=True)
class ChosenTopics:
    """Topics that a bag holds.

    Attributes:
        depth: Depth images.
        info: Their CameraInfo; None where there is none.
        colour: None without.
        odometry: None without.
        transforms: All that tell transforms.
    """

    depth: str
    info: str | None
    colour: str | None
    odometry: str | None
    transforms: tuple[str, ...]

    @property
    def all(self) -> set[str]:
        """Every one of them."""
        single = (self.depth, self.info, self.colour, self.odometry)
        return {name for name in (*single, *self.transforms) if name is not None}


def chosen(bag: Bag, wanted: TopicNames) -> ChosenTopics:
    """The topics that are asked for, and for the others sensible guesses.

    Raises:
        InputError: The bag does not hold what is asked for, no depth, or several topics that are
            as likely; or a topic that is asked for holds something else.
    """
    images = (IMAGE, COMPRESSED_IMAGE)
    depth = _named(bag, wanted.depth, "--depth-topic", *images) or _only_likeliest(bag)
    space = depth.removesuffix(COMPRESSED).removesuffix("/compressed").rsplit("/", 1)[0]
    info = _named(bag, wanted.info, "--info-topic", CAMERA_INFO)
    info = info or _info_beside(_of_kind(bag.topics, CAMERA_INFO), space, depth)
    odometry = None
    if wanted.odometry != "":
        odometry = _named(bag, wanted.odometry, "--odometry-topic", ODOMETRY)
        odometry = odometry or _odometry(bag)
    transforms = tuple(_of_kind(bag.topics, TRANSFORMS, "tf/tfMessage", "tf/msg/tfMessage"))
    colour = _named(bag, wanted.colour, "--colour-topic", IMAGE, but=depth) or _colour(bag, depth)
    return ChosenTopics(depth, info, colour, odometry, transforms)


def require_info(bag: Bag, topics: ChosenTopics) -> None:
    """Check that something tells of the camera.

    Raises:
        InputError: No topic does.
    """
    if topics.info is None:
        raise InputError(
            f"{bag.path}: no CameraInfo belongs to {topics.depth}; name its topic by "
            "--info-topic or give --intrinsics FX FY CX CY"
        )


def _of_kind(topics: Mapping[str, Topic], *kinds: str) -> list[str]:
    return sorted(name for name, topic in topics.items() if topic.kind in kinds)


def _named(bag: Bag, name: str | None, flag: str, *kinds: str, but: str = "") -> str | None:
    """The topic that is asked for, if it is there and holds what can be used."""
    if name is None:
        return None
    if name not in bag.topics:
        raise InputError(
            f"{bag.path}: holds no {name} ({flag}) but {', '.join(sorted(bag.topics))}"
        )
    held = bag.topics[name].kind
    if held not in kinds:
        fitting = [topic for topic in _of_kind(bag.topics, *kinds) if topic != but]
        raise InputError(
            f"{bag.path}: {name} ({flag}) holds {held or 'several types'}, not "
            f"{' or '.join(kinds)}; {', '.join(fitting) or 'no topic'} would fit"
        )
    return name


def _only_likeliest(bag: Bag) -> str:
    images = _of_kind(bag.topics, IMAGE, COMPRESSED_IMAGE)
    depths = [
        n for n in images if "depth" in n.lower() and not n.endswith(("/compressed", "/theora"))
    ]
    plain = [name for name in depths if bag.topics[name].kind == IMAGE] or depths
    for word in USUAL:
        usual = [name for name in plain if name.endswith(word)]
        if usual:
            plain = usual
            break
    if len(plain) == 1:
        return plain[0]
    if plain:
        raise InputError(
            f"{bag.path}: several topics may hold the depth: {', '.join(plain)}; choose one by "
            "--depth-topic"
        )
    raise InputError(
        f"{bag.path}: no topic holds depth images; there are {', '.join(sorted(bag.topics))}; "
        "name one by --depth-topic"
    )


def _info_beside(infos: list[str], space: str, depth: str) -> str | None:
    """The CameraInfo in the namespace of the images, or in that of their own topic."""
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
            f"{bag.path}: several topics hold odometry: {', '.join(found)}; choose one by "
            '--odometry-topic, or none by --odometry-topic ""'
        )
    return found[0] if found else None


def _colour(bag: Bag, depth: str) -> str | None:
    images = _of_kind(bag.topics, IMAGE)
    # A depth image that is aligned to the colour has both words in its name.
    found = [
        name
        for name in images
        if name != depth
        and ("color" in name.lower() or "rgb" in name.lower())
        and "depth" not in name.lower()
    ]
    return found[0] if len(found) == 1 else None
