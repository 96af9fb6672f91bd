"""`circumspect replay`."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.given_flags import given_flags
from circumspect.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from circumspect.cli.watched_replay import ReplayWatch
    from circumspect.pipeline import RecognitionPipeline
    from circumspect.recording import BagSettings, Recording
    from circumspect.sensing import BoxSegmentation, RgbdFrame

Box = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class Replay:
    """Recorded RGB-D frames through the pipeline: names what stands there.

    $ circumspect replay run.mcap
    $ circumspect replay robot.bag --depth-topic /depth --mount 0.1 0 0.9 90 30
    $ circumspect replay redkitchen --box -1.445 .746 1.811 -.947 -.337 2.101
    $ circumspect replay redkitchen --box X Y Z X Y Z --poses hidden
    $ circumspect replay run.mcap --viewer
    """

    recording: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RECORDING")]
    """An MCAP file; a bag of ROS 2 (folder or db3 file) or ROS 1; or a folder in the layout of
    7-Scenes (frame-*.depth.png, frame-*.pose.txt, where present gravity-direction.txt and
    frame-*.color.jpg) or of TUM RGB-D (depth.txt, where present rgb.txt and groundtruth.txt), with
    camera-intrinsics.txt where present."""
    box: Annotated[Box | None, tyro.conf.arg(metavar="X Y Z X Y Z")] = None
    """Two opposite corners of an upright box round the object [m]. Without it the object is what
    stands on the floor nearest to where the camera looks, which needs a bag's robot."""
    box_frame: Literal["world", "map"] = "world"
    """Frame of the corners: world, that of the recorded poses, or map, the same turned so that z
    is up. The edges of the box are along the map's axes in both cases."""
    poses: Literal["given", "hidden"] | None = None
    """given: the recorded poses are taken as true (the default for folders). hidden: only the
    first one is; the others are found by registration, from the odometry where there is any, and
    compared with the recorded ones at the end. Of a bag, without this flag, none is used."""
    every: int = 1
    """Take each n-th frame only."""
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
    mount: Annotated[
        tuple[float, float, float, float, float] | None,
        tyro.conf.arg(metavar="X Y Z PAN TILT"),
    ] = None
    """Of a bag whose transforms do not tell it: where the camera stands on the robot [m], and
    where it looks: counter-clockwise from straight on, and down [degrees]."""
    out: Path | None = None
    """Folder of the run; runs/replay-DATE-TIME by default."""
    weights: Path | None = None
    """A classifier of your own, made by `circumspect export`; without it the shipped one."""
    viewer: bool = False
    """Show the replay in the browser, where it can be paused; the page stays when it is over."""
    page: Annotated[PageFlags, tyro.conf.arg(name="")] = field(default_factory=PageFlags)
    """Where the dashboard is shown."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self) -> int:
        """Replay, model, name, save."""
        if self.viewer:
            from circumspect.cli.watched_replay import watched_replay

            return watched_replay(self)
        self.replay()
        return 0

    def replay(self, watch: ReplayWatch | None = None) -> None:
        """From the first frame to the report.

        Args:
            watch: Shows it, where wanted.
        """
        from circumspect.classification import Classifier
        from circumspect.cli.recorded_poses import RecordedPoses
        from circumspect.cli.run_screen import RunScreen, new_run_folder, tell_result
        from circumspect.pipeline import RunFolder
        from circumspect.pipeline.replayed import replay_pipeline
        from circumspect.recording import GivenPoses, is_bag, open_recording

        self._require_bag_for_its_flags()
        hidden = self.poses == "hidden" or (self.poses is None and is_bag(self.recording))
        # What a bag's transforms tell may be another pipeline's guess: asked for, or not used.
        wanted = GivenPoses.NONE if hidden and self.poses is None else GivenPoses.ALL
        frames = open_recording(self.recording, self.every, wanted, self._bag_settings())
        box = self._boxed(frames)
        pipeline = replay_pipeline(frames, Classifier.load(self.weights), box, hidden)
        recorded = RecordedPoses()
        config = self._config(box, pipeline, hidden)
        folder = RunFolder(self.out or new_run_folder("replay"), config)
        given: Iterable[RgbdFrame] = recorded.hidden(frames.placed()) if hidden else _posed(frames)
        given, shown = (given, ()) if watch is None else watch.watched(given)
        with RunScreen("replaying frames", len(frames)) as screen:
            pipeline.observers = (screen, *shown, folder)
            try:
                result = pipeline.run(given)
            except KeyboardInterrupt:
                screen.say(f"what was gathered so far is in {folder.path}")
                raise
            finally:
                for name, reason in frames.skipped.items():
                    screen.say(f"{name} left out: {reason}")
        head: dict[str, Any] = {"recording": str(self.recording), "skipped": len(frames.skipped)}
        head |= recorded.errors(result)
        tell_result(result, folder, self.json, head)
        if not self.json and head.get("ate_rmse_m") is not None:
            print(recorded.sentence(head))  # noqa: T201

    def _require_bag_for_its_flags(self) -> None:
        from circumspect.recording import is_bag

        if is_bag(self.recording) or not self.recording.is_dir():
            return
        given = given_flags(
            self, "depth_topic", "info_topic", "colour_topic", "odometry_topic", "map_frame",
            "intrinsics", "size", "mount",
        )  # fmt: skip
        if given:
            raise InputError(
                f"{self.recording}: is no bag; only bags take {', '.join(given)}; a folder tells "
                "of its camera in camera-intrinsics.txt"
            )

    def _bag_settings(self) -> BagSettings:
        import numpy as np

        from circumspect.geometry import PinholeCamera
        from circumspect.recording import BagSettings, TopicNames
        from circumspect.sensing.viewing import looking

        topics = TopicNames(
            self.depth_topic, self.info_topic, self.colour_topic, self.odometry_topic
        )
        camera = None if self.intrinsics is None else PinholeCamera(*self.size, *self.intrinsics)
        mount = None
        if self.mount is not None:
            pan, tilt = np.radians(self.mount[3:])
            mount = looking(self.mount[:3], float(pan), float(tilt))
        return BagSettings(topics, camera, mount, self.map_frame)

    def _boxed(self, frames: Recording) -> BoxSegmentation | None:
        import numpy as np

        from circumspect.sensing import BoxSegmentation

        if self.box is None:
            return None
        corners = np.array(self.box).reshape(2, 3)
        if self.box_frame == "world":
            corners = frames.T_map_world.apply(corners)
        return BoxSegmentation(corners[0], corners[1])

    def _config(
        self, box: BoxSegmentation | None, pipeline: RecognitionPipeline, hidden: bool
    ) -> dict[str, Any]:
        from circumspect import __version__

        told: dict[str, Any] = {
            "command": "replay",
            "version": __version__,
            "recording": str(self.recording),
            "poses": "hidden" if hidden else "given",
            "every": self.every,
            "model": asdict(pipeline.model.settings),
            "grid": pipeline.classifier.recipe.to_dict(),
        }
        if box is None or self.box is None:
            return {**told, "segmentation": {"kind": "ground"}}
        return {
            **told,
            "box": list(self.box),
            "box_frame": self.box_frame,
            "box_in_map": [
                [round(float(value), 4) for value in corner]
                for corner in (box.low_xyz, box.high_xyz)
            ],
            "segmentation": {"kind": "box", "noise": asdict(box.noise)},
        }


def _posed(frames: Recording) -> Iterable[RgbdFrame]:
    """Frames whose recorded poses are taken as true; a bag may lack them."""
    from circumspect.recording import BagRecording

    return frames.with_poses() if isinstance(frames, BagRecording) else frames
