"""`circumspect replay`."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.recording_flags import RecordingFlags

if TYPE_CHECKING:
    from circumspect.cli.opened_recording import OpenedRecording
    from circumspect.cli.watched_replay import ReplayWatch
    from circumspect.recognition import RecognitionPipeline


@dataclass(frozen=True)
class Replay:
    """Run the pipeline on recorded RGB-D frames and classify the object.

    $ circumspect replay run.mcap
    $ circumspect replay robot.bag --depth-topic /depth --mount 0.1 0 0.9 90 30
    $ circumspect replay redkitchen --box -1.445 .746 1.811 -.947 -.337 2.101
    $ circumspect replay redkitchen --box X Y Z X Y Z --poses hidden
    $ circumspect replay my_frames --first-pose 0 0 1.2 0 30
    $ circumspect replay run.mcap --viewer
    """

    recording: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RECORDING")]
    """MCAP file; bag of ROS 2 (folder or db3 file) or ROS 1; or folder in the layout of 7-Scenes
    (frame-*.depth.png, frame-*.pose.txt, optionally frame-*.color.jpg), of TUM RGB-D or ETH3D
    (depth.txt, optionally rgb.txt, groundtruth.txt and calibration.txt), or of ScanNet or Open3D
    (depth/N.png). Folders may contain camera-intrinsics.txt, and gravity-direction.txt (down in the
    world of the poses), which is needed if z does not point up there."""
    reading: RecordingFlags = field(default_factory=RecordingFlags)
    """How to read the recording."""
    out: Path | None = None
    """Folder of the run; runs/replay-DATE-TIME by default."""
    model: ModelFlag = ROBOT
    """Shipped classifier (`circumspect models` lists them), or your own ONNX file written by
    `circumspect export`."""
    viewer: bool = False
    """Show and pause the replay in the browser; the page stays open afterwards."""
    page: PageFlags = field(default_factory=PageFlags)
    """Address of the dashboard."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Replay, map, classify, save."""
        if self.viewer:
            return self._watched_replay()
        return self.replay()

    def _watched_replay(self) -> int:
        """Replay with the dashboard, which stays open until Ctrl-C."""
        from circumspect.classification import Classifier
        from circumspect.cli.dashboard_page import stay
        from circumspect.cli.say import say
        from circumspect.cli.watched_replay import ReplayWatch

        with self.page.opened(Classifier.load(self.model)) as dashboard:
            code = self.replay(ReplayWatch(dashboard))
            try:
                # Inside the block, because Ctrl-C may be pressed as soon as the line is printed.
                say("the page stays open until Ctrl-C")
                stay()
            except KeyboardInterrupt:
                say("the dashboard is closed")
        return code

    def replay(self, watch: ReplayWatch | None = None) -> int:
        """Run the replay and print the report.

        Args:
            watch: Shows the replay in the browser; None means no dashboard.

        Returns:
            Exit code: 0, or `NO_ANSWER`.
        """
        from circumspect.classification import Classifier
        from circumspect.cli.run_screen import NO_ANSWER, new_run_folder, print_result, wrapped
        from circumspect.recognition import run_pipeline
        from circumspect.runs import RunFolder
        from circumspect.storage import write_json

        opened = self.reading.opened(self.recording)
        pipeline = opened.pipeline(Classifier.load(self.model))
        # If no frame can be read, no folder is made and no earlier run is replaced.
        given, shown = opened.given(), ()
        config = self._config(opened, pipeline)
        folder = RunFolder(self.out or new_run_folder("replay"), config)
        write_config(folder.path, self, "replay")
        if watch is not None:
            given, shown = watch.watched(given)
        with opened.screen() as screen:
            try:
                result = run_pipeline(pipeline, given, (screen, *shown, folder))
            except KeyboardInterrupt:
                screen.say(f"what was gathered so far is in {folder.path}")
                raise
        skipped, errors = dict(opened.frames.skipped), opened.poses.errors(result)
        write_json(folder.path / "replay.json", {"skipped": skipped, "measured": errors})
        head = {"recording": str(self.recording), "skipped": len(skipped), **errors}
        print_result(result, folder, self.json, head, screen.label)
        if not self.json and errors.get("ate_rmse_m") is not None:
            print(wrapped(opened.poses.sentence(errors)))  # noqa: T201
        return NO_ANSWER if result.prediction is None else 0

    def _config(self, opened: OpenedRecording, pipeline: RecognitionPipeline) -> dict[str, Any]:
        from circumspect import __version__
        from circumspect.cli.model_flag import model_record

        reading, box = self.reading, opened.box
        document: dict[str, Any] = {
            "command": "replay",
            "version": __version__,
            "recording": str(self.recording),
            "poses": "hidden" if opened.hidden else "given",
            "depth_range": list(reading.depth_range),
            "depth_scale": reading.depth_scale,
            "first_pose": None if reading.first_pose is None else list(reading.first_pose),
            "every": reading.every,
            "model": asdict(pipeline.model.settings),
            "grid": pipeline.classifier.input_spec.to_dict(),
            "classifier": model_record(self.model),
        }
        if box is None or reading.box is None:
            return {**document, "segmentation": {"kind": "ground"}}
        return {
            **document,
            "box": list(reading.box),
            "box_frame": reading.corners_frame,
            "box_in_map": [
                [round(float(value), 4) for value in corner]
                for corner in (box.low_xyz, box.high_xyz)
            ],
            "segmentation": {"kind": "box", "noise": asdict(box.noise)},
        }
