"""Parameters of the node."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_type_hints

from circumspect.errors import InputError
from circumspect.ros.names import node_path, topic_path

if TYPE_CHECKING:
    from circumspect.sensing import DepthNoise

MAX_FILE_BYTES = 2**18
"""Maximum size of a parameter file [bytes]."""
PARAMETERS_KEY = "ros__parameters"
ANY_NODE = "/**"


@dataclass(frozen=True)
class Driver:
    """Defaults of a camera driver.

    Attributes:
        depth: Topic of the depth images.
        depth_range: Minimum and maximum depth that the camera measures well [m].
    """

    depth: str
    depth_range: tuple[float, float]


DRIVERS = {
    "realsense": Driver("/camera/camera/depth/image_rect_raw", (0.3, 3.0)),
    "orbbec": Driver("/camera/depth/image_raw", (0.6, 5.0)),
    "openni": Driver("/camera/depth/image", (0.8, 3.5)),
}
"""Camera drivers with the ideal depth ranges of the data sheets: RealSense D435, Orbbec Astra 2
(data sheet v1.0), Xtion PRO."""
LENGTHS = {
    "mount": (0, 5),
    "box": (0, 6),
    "intrinsics": (0, 4),
    "size": (2,),
    "depth_range": (0, 2),
}
"""Parameters that are lists of numbers, with the allowed lengths."""
MAX_SIDE_PX = 8192
"""Maximum image side [px]."""
INTEGER_LIMIT = 2**63
"""Bound of the absolute value of integer ROS parameters."""
ROS_PARAMETERS = ("use_sim_time",)
"""Parameters of every node, without effect here: this node uses the stamps of messages."""


@dataclass(frozen=True)
class NodeSettings:
    """Parameters of the node, as flags or in a parameter file.

    The metadata "off" of a field is the help text of the flag that disables it.

    Attributes:
        name: Name of the node; its topics are below it.
        namespace: Namespace of the node; "" for none.
        driver: Driver whose depth topic and range are the defaults: realsense, orbbec or openni.
        depth: Depth images (16UC1 or 32FC1); "" for the default of the driver.
        info: CameraInfo of the depth camera; "" for camera_info next to the depth images.
        odometry: nav_msgs/Odometry; "" to use transforms instead.
        odom_frame: Frame of the odometry in transforms; odometry messages name their own frame.
        base_frame: Frame of the robot.
        poses: "found": estimate poses by registration and odometry. "given": use the transforms
            from map_frame to the camera.
        map_frame: Frame of given poses.
        frame: Name of the output frame if poses are found: the corrected odometry frame.
        transforms: Whether to publish the transform to the output frame on /tf.
        mount: Pose of the camera on the robot [m, degrees]: x, y, z, pan (counter-clockwise from
            straight ahead), tilt (down); empty to use transforms.
        intrinsics: fx, fy, cx, cy [px] of a camera without CameraInfo; empty otherwise.
        size: Width and height of the images described by intrinsics [px].
        depth_range: Minimum and maximum depth of the camera [m]; empty for the default of the
            driver. Without a box, points outside this range are not part of the object; planned
            views keep the object inside it.
        box: Two opposite corners x y z x y z [m] of a box around the object; empty to use whatever
            stands on the floor in front of the camera.
        rate: Maximum number of frames per second to process; 0 for all.
        queue: Maximum number of waiting frames; further frames replace the oldest.
        reliable: Request reliable delivery of sensor data; publishers must then be reliable.
        autostart: Whether to start immediately, without a message on ~/start.
        model: Name of an included classifier (see `circumspect models`), or your own ONNX file.

    Raises:
        InputError: A value is invalid.
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
    transforms: bool = field(default=True, metadata={"off": "Do not publish that transform."})
    mount: tuple[float, ...] = ()
    intrinsics: tuple[float, ...] = ()
    size: tuple[float, ...] = (640.0, 480.0)
    depth_range: tuple[float, ...] = ()
    box: tuple[float, ...] = ()
    rate: float = 5.0
    queue: int = 4
    reliable: bool = False
    autostart: bool = field(default=True, metadata={"off": "Wait for a message on ~/start."})
    model: str = "robot"

    def __post_init__(self) -> None:
        if self.driver not in DRIVERS:
            raise InputError(f"no driver {self.driver[:40]!r}; known: {', '.join(DRIVERS)}")
        if self.poses not in ("found", "given"):
            raise InputError(f"poses must be found or given, not {self.poses[:40]!r}")
        for name, lengths in LENGTHS.items():
            if len(getattr(self, name)) not in lengths:
                raise InputError(f"{name} takes {lengths[-1]} numbers, not {getattr(self, name)}")
        if not all(1 <= side <= MAX_SIDE_PX and side == int(side) for side in self.size):
            raise InputError(
                f"the size is width and height in whole pixels up to {MAX_SIDE_PX}, not "
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
        """Create settings from parameters, with defaults for the others.

        Raises:
            InputError: A name is unknown, or a value has the wrong type or is invalid.
        """
        kinds, known = get_type_hints(cls), [field.name for field in fields(cls)]
        read: dict[str, Any] = {}
        for name, value in values.items():
            if name in ROS_PARAMETERS:
                continue
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
                raise InputError(f"no parameter {name[:40]!r}; {hint}")
            read[name] = _read(name, value, kinds[name])
        return cls(**read)

    @property
    def node(self) -> str:
        """Full name of the node."""
        return node_path(self.namespace, self.name)

    @property
    def noise(self) -> DepthNoise:
        """Depth noise of the Xtion PRO within the range of the camera.

        Raises:
            InputError: The range is invalid.
        """
        from circumspect.sensing import DepthNoise

        nearest, farthest = self.depth_range or DRIVERS[self.driver].depth_range
        return DepthNoise(nearest, farthest)

    @property
    def depth_topic(self) -> str:
        """Full name of the depth topic."""
        return topic_path(self.depth or DRIVERS[self.driver].depth, self.node)

    @property
    def info_topic(self) -> str | None:
        """Full name of the CameraInfo topic; None if intrinsics are given."""
        if self.intrinsics:
            return None
        default = f"{self.depth_topic.rsplit('/', 1)[0]}/camera_info"
        return topic_path(self.info, self.node) if self.info else default

    @property
    def odometry_topic(self) -> str | None:
        """Full name of the odometry topic; None if transforms are used."""
        return topic_path(self.odometry, self.node) if self.odometry else None

    @property
    def output_frame(self) -> str:
        """Frame of all published results."""
        return self.map_frame if self.poses == "given" else self.frame


def _read(name: str, value: Any, kind: Any) -> Any:
    """A parameter value converted to its type."""
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
    expected = "a list of numbers" if listed else wanted.get(kind, "a text")
    raise InputError(f"the parameter {name} is {expected}, not {_shortened(value)}")


def _shortened(value: Any) -> str:
    """The beginning of a value, for an error message."""
    too_long = "one of more than 18 digits"
    if isinstance(value, int) and abs(value) >= INTEGER_LIMIT:
        return too_long
    try:
        return repr(str(value)[:40])
    except ValueError:  # Python does not print integers of thousands of digits.
        return too_long


def _is_number(value: Any) -> bool:
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) < INTEGER_LIMIT
    return isinstance(value, float) and math.isfinite(value)


def read_parameters(path: str | os.PathLike[str], node: str) -> dict[str, Any]:
    """Read the parameters of a node from a file.

    Args:
        path: YAML file: node names, below each `ros__parameters`, below it names and values.
            Parameters below `/**` apply to every node.
        node: Full name of the node.

    Raises:
        InputError: The file cannot be read, is not a parameter file, or has no parameters of the
            node.
        MissingExtraError: PyYAML is not installed.
    """
    # A command has these settings as its flags, which are parsed without NumPy.
    from circumspect.sensing.untrusted_files import read_yaml

    document = read_yaml(Path(path), MAX_FILE_BYTES, "a parameter file", "ros2")
    found: dict[str, dict[str, Any]] = {}
    _collect(document, "", found, path)
    names = (ANY_NODE, node.rsplit("/", 1)[-1], node.removeprefix("/"), node)
    matching = [found[name] for name in names if name in found]
    if not matching:
        raise InputError(
            f"{path}: contains no {PARAMETERS_KEY} of the node {node}; nodes: "
            f"{', '.join(found) or 'none'}; give --name, or /** for any node"
        )
    return {name: value for one in matching for name, value in one.items()}


def _collect(
    document: Any, name: str, found: dict[str, dict[str, Any]], path: str | os.PathLike[str]
) -> None:
    """Collect the parameters of all nodes; namespaces may be nested."""
    if not isinstance(document, dict):
        raise InputError(f"{path}: is not a parameter file of nodes with {PARAMETERS_KEY}")
    for key, value in document.items():
        if key == PARAMETERS_KEY:
            if not isinstance(value, dict) or not all(isinstance(one, str) for one in value):
                raise InputError(
                    f"{path}: {PARAMETERS_KEY} of {name or 'no node'} must contain names and values"
                )
            found[name] = value
        else:
            _collect(value, f"{name}/{key}" if name else str(key), found, path)
