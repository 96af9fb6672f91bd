"""Flags that say how a recording is to be read."""

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
"""Place [m], pan and tilt [degrees]."""


DEPTH_SCALES = 1e-6, 0.1
"""Least and most of a unit of depth [m]."""


@dataclass(frozen=True)
class RecordingFlags:
    """Part of every command that takes a recording through the pipeline."""

    box: Annotated[Box | None, tyro.conf.arg(metavar="X Y Z X Y Z")] = None
    """Two opposite corners of an upright box round the object [m]. Without it the object is what
    stands on the floor nearest to where the camera looks, which needs a bag's robot or
    --first-pose."""
    box_frame: Literal["world", "map"] = "world"
    """Frame of the corners: world, that of the recorded poses, or map, the same turned so that z
    is up. The edges of the box are along the map's axes in both cases."""
    poses: Literal["given", "hidden"] | None = None
    """given: the recorded poses are taken as true (the default for folders). hidden: only the
    first one is; the others are found by registration, from the odometry where there is any, and
    `replay` compares them with the recorded ones at the end. Of a bag, without this flag, none is
    used."""
    first_pose: Annotated[View | None, tyro.conf.arg(metavar="X Y Z PAN TILT")] = None
    """Of a folder without poses: where the camera was at the first frame, with the floor at Z = 0
    [m], and where it looked: counter-clockwise from x, and down [degrees]. All other poses are
    found by registration. Without --box the object is what stands on the floor nearest to where
    the camera looks; corners of a box are in this frame."""
    every: int = 1
    """Take each n-th frame of the recording only."""
    depth_range: Annotated[tuple[float, float], tyro.conf.arg(metavar="NEAR FAR")] = (0.8, 3.5)
    """The nearest and the farthest depth that the camera measures [m]: without --box, what
    stands beyond is no object."""
    depth_scale: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Metres a unit of the depth images: 0.001 for millimetres, 0.00025 for quarters of them. By
    default that of the layout (TUM RGB-D: 0.0002) or of the encoding."""
    depth_topic: str | None = None
    """Of a bag: the depth images; without it the only likely topic."""
    info_topic: str | None = None
    """Of a bag: the depth camera's CameraInfo; without it that beside the images."""
    colour_topic: str | None = None
    """Of a bag: colour images that lie on the depth images."""
    odometry_topic: str | None = None
    """Of a bag: the wheels' odometry; "" for none."""
    map_frame: str = "map"
    """Of a bag: the frame in which its transforms tell the recorded poses."""
    intrinsics: Annotated[
        tuple[float, float, float, float] | None, tyro.conf.arg(metavar="FX FY CX CY")
    ] = None
    """Of a bag without CameraInfo, with --size: focal lengths and principal point [px]."""
    size: Annotated[tuple[int, int], tyro.conf.arg(metavar="WIDTH HEIGHT")] = (640, 480)
    """Of the depth images that --intrinsics describe [px]."""
    mount: Annotated[View | None, tyro.conf.arg(metavar="X Y Z PAN TILT")] = None
    """Of a bag whose transforms do not tell it: where the camera stands on the robot [m], and
    where it looks: counter-clockwise from straight on, and down [degrees]."""

    def opened(self, path: Path) -> OpenedRecording:
        """Open a recording.

        Args:
            path: A bag or a folder.

        Raises:
            InputError: It is none, does not hold what the flags say, or they do not fit it.
            MissingExtraError: It is a bag, and what reads bags is not installed.
        """
        from circumspect.cli.opened_recording import OpenedRecording
        from circumspect.recording import BagRecording, is_bag, open_recording
        from circumspect.recording.frame_folder import FrameFolder
        from circumspect.sensing import DepthNoise

        with flags_named(self, "depth_range"):
            noise = DepthNoise(*self.depth_range)
        self._require_depth_scale()
        self._require_bag_for_its_flags(path)
        self._require_folder_for_its_flags(path)
        registered = is_bag(path) or self.first_pose is not None
        hidden = self.poses == "hidden" or (self.poses is None and registered)
        # What a bag's transforms tell may be another pipeline's guess: asked for, or not used.
        wanted = not (hidden and self.poses is None)
        settings = self._bag_settings()
        frames = open_recording(path, self.every, wanted, settings, self.depth_scale)
        if isinstance(frames, FrameFolder) and not frames.has_poses:
            if not registered:
                raise InputError(
                    f"{path}: holds no poses; tell where the camera was at the first frame, and "
                    "registration finds the others: --first-pose X Y Z PAN TILT"
                )
            frames.poses = False
        if isinstance(frames, BagRecording) and frames.systematic_disparity is not None:
            noise = replace(noise, systematic_disparity=frames.systematic_disparity)
        first = None if self.first_pose is None else view_pose(self.first_pose)
        return OpenedRecording(frames, self._boxed(frames, noise), hidden, first, noise)

    @property
    def corners_frame(self) -> Literal["world", "map"]:
        """Frame of the box; a first pose that was given is one in the map."""
        return self.box_frame if self.first_pose is None else "map"

    def told(self) -> dict[str, Any]:
        """The values that are not the usual ones, JSON types."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        usual = RecordingFlags()
        return {name: told for name, told in values.items() if told != getattr(usual, name)}

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
                f"{path}: is no bag; only bags take {', '.join(given)}; a folder tells of its "
                "camera in camera-intrinsics.txt"
            )

    def _require_folder_for_its_flags(self, path: Path) -> None:
        from circumspect.recording import is_bag

        if self.first_pose is None:
            return
        if is_bag(path):
            raise InputError(
                f"{path}: is a bag, whose map begins under its robot; --first-pose is for folders; "
                "give --mount where its transforms do not tell it"
            )
        if self.poses == "given":
            raise InputError("--first-pose takes the place of the poses of --poses given: give one")
        if self.box is None:
            from circumspect.cli.first_pose import require_above_floor

            require_above_floor(self.first_pose[2])

    def _bag_settings(self) -> BagSettings:
        from circumspect.geometry import PinholeCamera
        from circumspect.recording import BagSettings, TopicNames

        if self.intrinsics is None and given_flags(self, "size"):
            raise InputError("--size tells of the images that --intrinsics describe: give both")
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
        InputError: It is none.
    """
    import numpy as np

    from circumspect.sensing.viewing import looking

    pan, tilt = np.radians(view[3:])
    return looking(view[:3], float(pan), float(tilt))
