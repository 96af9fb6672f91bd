"""Flags that define how to read a recording."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.given_flags import flags_named, given_flags
from circumspect.errors import InputError

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

    from circumspect.cli.opened_recording import OpenedRecording
    from circumspect.recording import BagSettings, Recording
    from circumspect.sensing import BoxSegmentation, DepthNoise

Box = tuple[float, float, float, float, float, float]
View = tuple[float, float, float, float, float]
"""Position [m], pan and tilt [degrees]."""
DEPTH_SCALES = 1e-6, 0.1
"""Minimum and maximum of a unit of depth [m]."""
HIGHEST = 10.0
"""Maximum height of a camera above the floor [m]; larger values are probably millimetres."""


@dataclass(frozen=True)
class RecordingFlags:
    """Flags of commands that run the pipeline on a recording."""

    box: Annotated[Box | None, tyro.conf.arg(metavar="X Y Z X Y Z")] = None
    """Two opposite corners of an upright box round the object [m]. Without this flag, the
    object on the floor nearest to the viewing direction is used, which requires a bag with a robot
    or --first-pose."""
    box_frame: Literal["world", "map"] = "world"
    """Frame of the corners: world (that of the recorded poses) or map (the same frame turned so
    that z points up). In both cases the edges of the box are parallel to the axes of the map."""
    poses: Literal["given", "hidden"] | None = None
    """given: use the recorded poses as true (default for folders). hidden: use only the first pose;
    the others are estimated by registration, starting from odometry if there is any, and `replay`
    compares them with the recorded poses at the end. By default, no recorded pose of a bag is
    used."""
    first_pose: Annotated[View | None, tyro.conf.arg(metavar="X Y Z PAN TILT")] = None
    """Folders without poses: position of the camera at the first frame, with the floor at Z = 0
    [m], pan (counter-clockwise from x) and tilt (down) [degrees]. All other poses are estimated by
    registration. Without --box, the object on the floor nearest to the viewing direction is
    used; the corners of --box are in this frame."""
    every: int = 1
    """Use only every n-th frame of the recording."""
    depth_range: Annotated[tuple[float, float], tyro.conf.arg(metavar="NEAR FAR")] = (0.8, 3.5)
    """Minimum and maximum depth that the camera measures [m]; without --box, the object is searched
    within this range."""
    depth_scale: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Metres per unit of the depth images, such as 0.001 for millimetres or 0.00025 for quarters of
    a millimetre. By default that of the layout (TUM RGB-D: 0.0002) or of the encoding."""
    depth_topic: str | None = None
    """Bags only: topic of the depth images; by default the only plausible one."""
    info_topic: str | None = None
    """Bags only: topic of the depth camera's CameraInfo; by default the one beside the images."""
    colour_topic: str | None = None
    """Bags only: topic of colour images that are registered to the depth images."""
    odometry_topic: str | None = None
    """Bags only: topic of the wheel odometry; "" for none."""
    map_frame: str = "map"
    """Bags only: frame of the recorded poses in the transforms."""
    intrinsics: Annotated[
        tuple[float, float, float, float] | None, tyro.conf.arg(metavar="FX FY CX CY")
    ] = None
    """Bags without CameraInfo, with --size: focal lengths and principal point [px]."""
    size: Annotated[tuple[int, int], tyro.conf.arg(metavar="WIDTH HEIGHT")] = (640, 480)
    """Size of the depth images, with --intrinsics [px]."""
    mount: Annotated[View | None, tyro.conf.arg(metavar="X Y Z PAN TILT")] = None
    """Bags without a transform to the camera: its position on the robot [m], pan (counter-clockwise
    from straight ahead) and tilt (down) [degrees]."""

    def opened(self, path: Path) -> OpenedRecording:
        """Open a recording.

        Args:
            path: Bag or folder.

        Raises:
            InputError: It is neither, lacks data that the flags name, or does not fit the flags.
            MissingExtraError: It is a bag, and the extra that reads bags is not installed.
        """
        from circumspect.cli.opened_recording import OpenedRecording
        from circumspect.recording import is_bag, open_recording
        from circumspect.sensing import DepthNoise

        with flags_named(self, "depth_range"):
            noise = DepthNoise(*self.depth_range)
        self._require_depth_scale()
        self._require_bag_for_its_flags(path)
        self._require_folder_for_its_flags(path)
        registered = is_bag(path) or self.first_pose is not None
        hidden = self.poses == "hidden" or (self.poses is None and registered)
        # Transforms of a bag may be estimates of another pipeline; they are used only on request.
        wanted = not (hidden and self.poses is None)
        settings = self._bag_settings()
        frames = open_recording(path, self.every, wanted, settings, self.depth_scale)
        if not frames.has_poses:
            if not registered:
                raise InputError(
                    f"{path}: contains no poses; say where the camera was at the first frame, and "
                    "registration finds the others: --first-pose X Y Z PAN TILT"
                )
            frames.poses = False
        if frames.systematic_disparity is not None:
            noise = replace(noise, systematic_disparity=frames.systematic_disparity)
        first = None if self.first_pose is None else view_pose(self.first_pose)
        return OpenedRecording(frames, self._boxed(frames, noise), hidden, first, noise)

    @property
    def corners_frame(self) -> Literal["world", "map"]:
        """Frame of the box; map if a first pose is given."""
        return self.box_frame if self.first_pose is None else "map"

    def changed(self) -> dict[str, Any]:
        """The values that differ from their defaults, in JSON types."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        usual = RecordingFlags()
        return {name: value for name, value in values.items() if value != getattr(usual, name)}

    def _require_depth_scale(self) -> None:
        scale, (low, high) = self.depth_scale, DEPTH_SCALES
        if scale is None or low <= scale <= high:
            return
        is_inverse = 1 / high <= scale <= 1 / low
        hint = f"; for {scale:g} units a metre give {1 / scale:g}" if is_inverse else ""
        raise InputError(f"--depth-scale {scale:g}: give metres a unit, {low:g} to {high:g}{hint}")

    def _require_bag_for_its_flags(self, path: Path) -> None:
        from circumspect.recording import is_bag

        if is_bag(path) or not path.is_dir():
            return
        given = given_flags(
            self, "depth_topic", "info_topic", "colour_topic", "odometry_topic", "map_frame",
            "intrinsics", "size", "mount",
        )  # fmt: skip
        if given:
            raise InputError(
                f"{path}: is no bag; only bags take {', '.join(given)}; a folder describes its "
                "camera in camera-intrinsics.txt"
            )

    def _require_folder_for_its_flags(self, path: Path) -> None:
        from circumspect.recording import is_bag

        if self.first_pose is None:
            return
        if is_bag(path):
            raise InputError(
                f"{path}: is a bag, whose map begins under its robot; --first-pose is for folders; "
                "give --mount where its transforms do not contain it"
            )
        if self.poses == "given":
            raise InputError("--first-pose takes the place of the poses of --poses given: give one")
        if self.box is None:
            require_above_floor(self.first_pose[2])

    def _bag_settings(self) -> BagSettings:
        from circumspect.geometry import PinholeCamera
        from circumspect.recording import BagSettings, TopicNames

        if self.intrinsics is None and given_flags(self, "size"):
            raise InputError("--size is of the images that --intrinsics describe: give both")
        topics = TopicNames(
            self.depth_topic, self.info_topic, self.colour_topic, self.odometry_topic
        )
        camera = None if self.intrinsics is None else PinholeCamera(*self.size, *self.intrinsics)
        mount = None if self.mount is None else view_pose(self.mount)
        return BagSettings(topics, camera, mount, self.map_frame)

    def _boxed(self, frames: Recording, noise: DepthNoise) -> BoxSegmentation | None:
        import numpy as np

        from circumspect.sensing import BoxSegmentation

        if self.box is None:
            return None
        corners = np.array(self.box).reshape(2, 3)
        if self.corners_frame == "world":
            corners = frames.T_map_world.apply(corners)
        return BoxSegmentation(corners[0], corners[1], noise)


def view_pose(view: View) -> RigidTransform:
    """The pose of an upright camera, optical frame.

    Raises:
        InputError: A value is invalid.
    """
    import numpy as np

    from circumspect.sensing.viewing import looking

    pan, tilt = np.radians(view[3:])
    return looking(view[:3], float(pan), float(tilt))


def require_above_floor(z: float) -> None:
    """Check the height of a camera above the floor.

    Args:
        z: Height above the floor [m].

    Raises:
        InputError: The height is not positive, or too large.
    """
    if not 0 < z <= HIGHEST:
        raise InputError(
            f"--first-pose: a camera {z:g} m above the floor; give Z in metres, above 0 and at "
            f"most {HIGHEST:g}, or the object's --box"
        )
