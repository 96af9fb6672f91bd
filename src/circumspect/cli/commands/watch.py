"""`circumspect watch`."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.recording_flags import View, view_pose
from circumspect.errors import InputError

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

    from circumspect.classification import Classifier
    from circumspect.recognition import RecognitionPipeline
    from circumspect.recording.realsense_camera import RealSenseCamera
    from circumspect.sensing import DepthNoise, RgbdFrame

REALSENSE = "realsense"
MAX_SEARCHED = 150
"""Maximum number of first frames that are searched for the floor."""


@dataclass(frozen=True)
class Watch:
    """Map and classify an object live with a camera, without ROS.

    $ circumspect watch --camera realsense
    $ circumspect watch --camera realsense --mount 0.1 0 0.9 0 30 --viewer
    $ circumspect watch --camera recording.db3 --json

    With a hand-held camera, keep object and floor in view. Ctrl-C ends the run.
    """

    camera: Annotated[str, tyro.conf.arg(metavar="realsense|FILE")] = REALSENSE
    """realsense: the first connected camera. FILE: a recording of the RealSense SDK."""
    mount: Annotated[View | None, tyro.conf.arg(metavar="X Y Z PAN TILT")] = None
    """Camera on a base: its position on the base [m], pan (counter-clockwise from straight ahead)
    and tilt (down) [degrees]. Without this flag the camera is hand-held, and its first pose is
    estimated from the visible floor."""
    first_pose: Annotated[View | None, tyro.conf.arg(metavar="X Y Z PAN TILT")] = None
    """Hand-held camera, instead of a search for the floor: its position at the first frame, with
    the floor at Z = 0 [m], pan and tilt [degrees]."""
    depth_range: Annotated[tuple[float, float] | None, tyro.conf.arg(metavar="NEAR FAR")] = None
    """Minimum and maximum depth that are used [m]; those of the device by default."""
    every: int = 1
    """Use only every n-th frame."""
    duration: Annotated[float | None, tyro.conf.arg(metavar="SECONDS")] = None
    """Time after which the run ends [s]."""
    out: Path | None = None
    """Folder of the run; runs/watch-DATE-TIME by default."""
    model: ModelFlag = ROBOT
    """Shipped classifier (`circumspect models` lists them), or your own ONNX file written by
    `circumspect export`."""
    viewer: bool = False
    """Show and pause the run in the browser."""
    page: PageFlags = field(default_factory=PageFlags)
    """Address of the dashboard."""
    json: bool = False
    """Print JSON lines on standard output and nothing else: one at each change of the answer, and
    the result last."""
    config: ConfigFlag = None

    def __post_init__(self) -> None:
        if self.every < 1:
            raise InputError(f"--every {self.every}: take each first, second, … frame")
        if self.duration is not None and not self.duration > 0:
            raise InputError(f"--duration {self.duration:g}: give seconds above 0")
        if self.mount is not None and self.first_pose is not None:
            raise InputError("--mount is for a camera on a base, --first-pose for one in the hand")

    def run(self) -> int:
        """Watch until Ctrl-C, the end of the file, or the end of --duration."""
        from circumspect.classification import Classifier
        from circumspect.recording.realsense_camera import RealSenseCamera

        classifier = Classifier.load(self.model)
        with ExitStack() as opened:
            file = None if self.camera == REALSENSE else self.camera
            camera = opened.enter_context(RealSenseCamera(file))
            return self._watch(camera, classifier, opened)

    def _watch(self, camera: RealSenseCamera, classifier: Classifier, opened: ExitStack) -> int:
        from circumspect.cli.node_screen import WatchScreen
        from circumspect.cli.run_screen import NO_ANSWER, new_run_folder, print_result
        from circumspect.cli.say import say
        from circumspect.cli.watched_replay import ReplayWatch
        from circumspect.recognition import run_pipeline
        from circumspect.runs import RunFolder
        from circumspect.sensing import DepthNoise

        noise = DepthNoise(*(self.depth_range or camera.depth_range))
        goes_on = opened.enter_context(until_ctrl_c(self.duration))
        say(f"{camera.name}, {noise.nearest:g} to {noise.farthest:g} m; Ctrl-C ends the run")
        T_first, frames = self._with_first_pose(_while(goes_on, camera))
        pipeline = self._pipeline(classifier, T_first, noise)
        folder = RunFolder(self.out or new_run_folder("watch"), self._config(camera, noise))
        write_config(folder.path, self, "watch")
        shown: tuple[Any, ...] = ()
        if self.viewer:
            dashboard = opened.enter_context(self.page.opened(classifier))
            frames, shown = ReplayWatch(dashboard).watched(frames)
        screen = WatchScreen(self.json)
        opened.callback(screen.end)
        result = run_pipeline(pipeline, frames, (screen, *shown, folder))
        print_result(result, folder, self.json, {"camera": self.camera, "device": camera.name})
        return NO_ANSWER if result.prediction is None else 0

    def _with_first_pose(
        self, frames: Iterator[RgbdFrame]
    ) -> tuple[RigidTransform | None, Iterable[RgbdFrame]]:
        """The first pose in the map, if there is one, and the frames from that pose on."""
        from circumspect.sensing.floor_plane import floor_pose

        if self.mount is not None:
            mount = view_pose(self.mount)
            return None, self._thinned(replace(frame, T_base_camera=mount) for frame in frames)
        if self.first_pose is not None:
            return view_pose(self.first_pose), self._thinned(frames)
        for _, frame in zip(range(MAX_SEARCHED), frames, strict=False):
            if (T_map_camera := floor_pose(frame)) is not None:
                return T_map_camera, self._thinned(chain([frame], frames))
        raise InputError(
            "no floor is seen in the first frames; hold the camera 0.3 to 2.5 m above it, looking "
            "down at the object and the floor before it, or give --first-pose X Y Z PAN TILT"
        )

    def _thinned(self, frames: Iterable[RgbdFrame]) -> Iterator[RgbdFrame]:
        return (frame for number, frame in enumerate(frames) if number % self.every == 0)

    def _pipeline(
        self, classifier: Classifier, T_first: RigidTransform | None, noise: DepthNoise
    ) -> RecognitionPipeline:
        from circumspect.recognition import RecognitionPipeline
        from circumspect.sensing import GroundSegmentation
        from circumspect.tracking import Tracker, TrackingSettings

        tracker = Tracker(T_first, TrackingSettings.for_noise(noise))
        return RecognitionPipeline(GroundSegmentation(noise=noise), tracker, classifier)

    def _config(self, camera: RealSenseCamera, noise: DepthNoise) -> dict[str, Any]:
        from circumspect import __version__
        from circumspect.cli.model_flag import model_record

        return {
            "command": "watch",
            "version": __version__,
            "camera": self.camera,
            "device": camera.name,
            "intrinsics": asdict(camera.intrinsics),
            "depth_range": list(noise.depth_range),
            "mount": None if self.mount is None else list(self.mount),
            "first_pose": None if self.first_pose is None else list(self.first_pose),
            "every": self.every,
            "classifier": model_record(self.model),
        }


def _while(goes_on: Callable[[], bool], frames: Iterable[RgbdFrame]) -> Iterator[RgbdFrame]:
    for frame in frames:
        if not goes_on():
            return
        yield frame


@contextmanager
def until_ctrl_c(seconds: float | None) -> Iterator[Callable[[], bool]]:
    """Yield a function that returns False after Ctrl-C, SIGTERM or the end of the time.

    A second Ctrl-C raises `KeyboardInterrupt`.

    Args:
        seconds: The time [s]; None means no limit.
    """
    from circumspect.cli.node_screen import going_on

    ended = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def end(*_: Any) -> None:
        ended.set()
        signal.signal(signal.SIGINT, before)

    with going_on(seconds) as in_time:
        if threading.current_thread() is not threading.main_thread():
            yield in_time
            return
        signal.signal(signal.SIGINT, end)
        try:
            yield lambda: not ended.is_set() and in_time()
        finally:
            signal.signal(signal.SIGINT, before)
