"""What a node can be told: its parameters."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal, get_type_hints

from circumspect.errors import InputError
from circumspect.ros.names import node_path, topic_path

if TYPE_CHECKING:
    from circumspect.sensing import DepthNoise


@dataclass(frozen=True)
class Driver:
    """What is usual of a driver.

    Attributes:
        depth: Topic of the depth images.
        depth_range: The nearest and the farthest depth that its camera measures well [m].
    """

    depth: str
    depth_range: tuple[float, float]


DRIVERS = {
    "realsense": Driver("/camera/camera/depth/image_rect_raw", (0.3, 3.0)),
    "orbbec": Driver("/camera/depth/image_raw", (0.6, 5.0)),
    "openni": Driver("/camera/depth/image", (0.8, 3.5)),
}
"""Drivers of cameras, with the ideal ranges that makers state: RealSense D435, Orbbec Astra 2 (its
data sheet v1.0), Xtion PRO."""
LENGTHS = {
    "mount": (0, 5),
    "box": (0, 6),
    "intrinsics": (0, 4),
    "size": (2,),
    "depth_range": (0, 2),
}
"""Parameters that are lists of numbers to how many those may be."""
MOST_PIXELS = 8192
"""Along a side of the images."""
INTEGER = 2**63
"""Whole numbers of ROS parameters are smaller."""
ROS_OWN = ("use_sim_time",)
"""Parameters that every node has; ours goes by the stamps of messages anyway."""


@dataclass(frozen=True)
class NodeSettings:
    """Parameters of the node; each is a flag and an entry of a parameter file as well.

    The metadata "off" of a field is the help of its flag where that switches something off.

    Attributes:
        name: Of the node; its own topics are below it.
        namespace: Before the name; "" for none.
        driver: Whose usual depth topic and depth range are taken: realsense, orbbec or openni.
        depth: Depth images (16UC1 or 32FC1); "" for the driver's.
        info: Their CameraInfo; "" for camera_info beside the depth images.
        odometry: nav_msgs/Odometry; "" takes it from transforms.
        odom_frame: Frame of the odometry in transforms; its messages name theirs themselves.
        base_frame: The robot's frame.
        poses: "found": by registration, from odometry. "given": transforms from map_frame to the
            camera are taken as true.
        map_frame: Frame of given poses.
        frame: What the frame is called in which the node tells everything, where it finds poses
            itself: it is the odometry's, corrected.
        transforms: Whether to tell on /tf where that frame lies.
        mount: Where the camera stands on the robot [m] and looks [degrees]: x, y, z, pan
            (counter-clockwise from straight on), tilt (down); empty takes it from transforms.
        intrinsics: fx, fy, cx, cy [px] of a camera without CameraInfo; empty with.
        size: Width and height [px] of the images that intrinsics describe.
        depth_range: The nearest and the farthest depth [m] that the camera measures; empty for
            those of the driver's camera. Without a box what stands beyond is no object, and next
            views are such that the object lies within.
        box: Two opposite corners x y z x y z [m] of a box round the object; empty takes what
            stands on the floor before the camera.
        rate: Frames a second that are taken of those that come; 0 for all.
        queue: Frames that may wait; when more come, the oldest give way.
        reliable: Ask for sensor data again that went missing; then publishers must be reliable.
        autostart: Whether to begin at once; otherwise when told to.
        model: Name of a shipped classifier (`circumspect models` lists them), or an ONNX file of
            your own.

    Raises:
        InputError: A value makes no sense.
    """

    name: str = "circumspect"
    namespace: str = ""
    driver: Literal["realsense", "orbbec", "openni"] = "realsense"
    depth: str = ""
    info: str = ""
    odometry: str = "/odom"
    odom_frame: str = "odom"
    base_frame: str = "base_link"
    poses: Literal["found", "given"] = "found"
    map_frame: str = "map"
    frame: str = "circumspect_map"
    transforms: bool = field(
        default=True, metadata={"off": "Do not tell on /tf where that frame lies."}
    )
    mount: tuple[float, ...] = ()
    intrinsics: tuple[float, ...] = ()
    size: tuple[float, ...] = (640.0, 480.0)
    depth_range: tuple[float, ...] = ()
    box: tuple[float, ...] = ()
    rate: float = 5.0
    queue: int = 4
    reliable: bool = False
    autostart: bool = field(default=True, metadata={"off": "Wait until told to begin, on ~/start."})
    model: str = "robot"

    def __post_init__(self) -> None:
        if self.driver not in DRIVERS:
            raise InputError(f"no driver {self.driver[:40]!r}; known: {', '.join(DRIVERS)}")
        if self.poses not in ("found", "given"):
            raise InputError(f"poses are found or given, not {self.poses[:40]!r}")
        for name, lengths in LENGTHS.items():
            if len(getattr(self, name)) not in lengths:
                raise InputError(f"{name} takes {lengths[-1]} numbers, not {getattr(self, name)}")
        if not all(1 <= side <= MOST_PIXELS and side == int(side) for side in self.size):
            raise InputError(
                f"the size is width and height in whole pixels up to {MOST_PIXELS}, not "
                f"{self.size[0]:g} x {self.size[1]:g}"
            )
        if not 0 <= self.rate <= 1000:
            raise InputError(f"the rate is from 0 (all frames) to 1000 Hz, not {self.rate}")
        if not 1 <= self.queue <= 100:
            raise InputError(f"the queue holds 1 to 100 frames, not {self.queue}")
        if "" in (self.frame, self.odom_frame, self.base_frame, self.map_frame):
            raise InputError("frame, odom_frame, base_frame and map_frame need names")
        for topic in (self.depth_topic, self.info_topic, self.odometry_topic):
            if topic is not None:
                topic_path(topic, self.node)

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any]) -> NodeSettings:
        """Settings of parameters by name, defaults for the others.

        Raises:
            InputError: A name is not known, or a value is of another kind or makes no sense.
        """
        kinds, known = get_type_hints(cls), [field.name for field in fields(cls)]
        read: dict[str, Any] = {}
        for name, value in values.items():
            if name in ROS_OWN:
                continue
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
                raise InputError(f"no parameter {name[:40]!r}; {hint}")
            read[name] = _read(name, value, kinds[name])
        return cls(**read)

    @property
    def node(self) -> str:
        """The node's full name."""
        return node_path(self.namespace, self.name)

    @property
    def noise(self) -> DepthNoise:
        """The camera's: the Xtion PRO's noise within its own range.

        Raises:
            InputError: The range is none.
        """
        from circumspect.sensing import DepthNoise

        nearest, farthest = self.depth_range or DRIVERS[self.driver].depth_range
        return DepthNoise(nearest, farthest)

    @property
    def depth_topic(self) -> str:
        """Full name of the depth images' topic."""
        return topic_path(self.depth or DRIVERS[self.driver].depth, self.node)

    @property
    def info_topic(self) -> str | None:
        """Full name of the CameraInfo's topic; None where intrinsics are given."""
        if self.intrinsics:
            return None
        beside = f"{self.depth_topic.rsplit('/', 1)[0]}/camera_info"
        return topic_path(self.info, self.node) if self.info else beside

    @property
    def odometry_topic(self) -> str | None:
        """Full name of the odometry's topic; None where transforms tell it."""
        return topic_path(self.odometry, self.node) if self.odometry else None

    @property
    def told_frame(self) -> str:
        """The frame in which the node tells everything."""
        return self.map_frame if self.poses == "given" else self.frame


def _read(name: str, value: Any, kind: Any) -> Any:
    """A value as its parameter wants it."""
    if kind is bool and isinstance(value, bool):
        return value
    if kind is int and isinstance(value, int) and _is_number(value):
        return value
    if kind is float and _is_number(value):
        return float(value)
    listed = kind == tuple[float, ...]
    if listed and isinstance(value, list | tuple) and all(_is_number(one) for one in value):
        return tuple(float(one) for one in value)
    if kind not in (bool, int, float) and not listed and isinstance(value, str):
        return value
    wanted = {bool: "true or false", int: "a whole number", float: "a number"}
    what = "a list of numbers" if listed else wanted.get(kind, "a text")
    raise InputError(f"the parameter {name} is {what}, not {_told(value)}")


def _told(value: Any) -> str:
    """The beginning of a value, for a message."""
    too_long = "one of more than 18 digits"
    if isinstance(value, int) and abs(value) >= INTEGER:
        return too_long
    try:
        return repr(str(value)[:40])
    except ValueError:  # A list of such: Python writes no number of thousands of digits.
        return too_long


def _is_number(value: Any) -> bool:
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) < INTEGER
    return isinstance(value, float) and math.isfinite(value)
