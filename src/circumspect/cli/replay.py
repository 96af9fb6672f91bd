"""`circumspect replay`."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.recording_flags import RecordingFlags

if TYPE_CHECKING:
    from circumspect.cli.opened_recording import OpenedRecording
    from circumspect.cli.watched_replay import ReplayWatch
    from circumspect.recognition import RecognitionPipeline


@dataclass(frozen=True)
class Replay:
    """Recorded RGB-D frames through the pipeline: names what stands there.

    $ circumspect replay run.mcap
    $ circumspect replay robot.bag --depth-topic /depth --mount 0.1 0 0.9 90 30
    $ circumspect replay redkitchen --box -1.445 .746 1.811 -.947 -.337 2.101
    $ circumspect replay redkitchen --box X Y Z X Y Z --poses hidden
    $ circumspect replay my_frames --first-pose 0 0 1.2 0 30
    $ circumspect replay run.mcap --viewer
    """

    recording: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RECORDING")]
    """An MCAP file; a bag of ROS 2 (folder or db3 file) or ROS 1; or a folder in the layout of
    7-Scenes (frame-*.depth.png, frame-*.pose.txt, where present frame-*.color.jpg), of TUM RGB-D or
    ETH3D (depth.txt, where present rgb.txt, groundtruth.txt and calibration.txt), or of ScanNet or
    Open3D (depth/N.png), with camera-intrinsics.txt where present and gravity-direction.txt (down,
    in the poses' world) where z does not point up there."""
    reading: Annotated[RecordingFlags, tyro.conf.arg(name="")] = field(
        default_factory=RecordingFlags
    )
    """How it is read."""
    out: Path | None = None
    """Folder of the run; runs/replay-DATE-TIME by default."""
    model: ModelFlag = ROBOT
    """A shipped classifier (`circumspect models` lists them), or an ONNX file of your own that
    `circumspect export` made."""
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
        return self.replay()

    def replay(self, watch: ReplayWatch | None = None) -> int:
        """From the first frame to the report.

        Args:
            watch: Shows it, where wanted.

        Returns:
            Exit code: 0, or `NO_ANSWER`.
        """
        from circumspect.classification import Classifier
        from circumspect.cli.run_screen import NO_ANSWER, new_run_folder, tell_result, wrapped
        from circumspect.recognition import run_pipeline
        from circumspect.runs import RunFolder
        from circumspect.storage import write_json

        opened = self.reading.opened(self.recording)
        pipeline = opened.pipeline(Classifier.load(self.model))
        # Where no frame can be read no folder is made, and no earlier run replaced.
        given, shown = opened.given(), ()
        config = self._config(opened, pipeline)
        folder = RunFolder(self.out or new_run_folder("replay"), config)
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
        tell_result(result, folder, self.json, head, screen.label)
        if not self.json and errors.get("ate_rmse_m") is not None:
            print(wrapped(opened.poses.sentence(errors)))  # noqa: T201
        return NO_ANSWER if result.prediction is None else 0

    def _config(self, opened: OpenedRecording, pipeline: RecognitionPipeline) -> dict[str, Any]:
        from circumspect import __version__
        from circumspect.cli.model_record import model_record

        reading, box = self.reading, opened.box
        told: dict[str, Any] = {
            "command": "replay",
            "version": __version__,
            "recording": str(self.recording),
            "poses": "hidden" if opened.hidden else "given",
            "depth_range": list(reading.depth_range),
            "depth_scale": reading.depth_scale,
            "first_pose": None if reading.first_pose is None else list(reading.first_pose),
            "every": reading.every,
            "model": asdict(pipeline.model.settings),
            "grid": pipeline.classifier.recipe.to_dict(),
            "classifier": model_record(self.model),
        }
        if box is None or reading.box is None:
            return {**told, "segmentation": {"kind": "ground"}}
        return {
            **told,
            "box": list(reading.box),
            "box_frame": reading.corners_frame,
            "box_in_map": [
                [round(float(value), 4) for value in corner]
                for corner in (box.low_xyz, box.high_xyz)
            ],
            "segmentation": {"kind": "box", "noise": asdict(box.noise)},
        }
