"""`circumspect replay`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

if TYPE_CHECKING:
    from circumspect.pipeline import RecognitionPipeline
    from circumspect.recording import FrameFolder
    from circumspect.sensing import BoxSegmentation

Box = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class Replay:
    """Recorded RGB-D frames through the pipeline: names what lies in a box.

    $ circumspect replay redkitchen --box -1.445 .746 1.811 -.947 -.337 2.101
    $ circumspect replay redkitchen --box X Y Z X Y Z --box-frame map --every 5
    $ circumspect replay redkitchen --box X Y Z X Y Z --poses hidden
    """

    recording: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER")]
    """Folder in the layout of 7-Scenes (frame-*.depth.png, frame-*.pose.txt, where present
    gravity-direction.txt and frame-*.color.jpg) or of TUM RGB-D (depth.txt, where present rgb.txt
    and groundtruth.txt); camera-intrinsics.txt where present."""
    box: Annotated[Box, tyro.conf.arg(metavar="X Y Z X Y Z")]
    """Two opposite corners of an upright box round the object [m]."""
    box_frame: Literal["world", "map"] = "world"
    """Frame of the corners: world, that of the recorded poses, or map, the same turned so that z
    is up. The edges of the box are along the map's axes in both cases."""
    poses: Literal["given", "hidden"] = "given"
    """given: the recorded poses are taken as true. hidden: only the first one is; the others are
    found by registration and compared with the recorded ones at the end."""
    every: int = 1
    """Take each n-th frame only."""
    out: Path | None = None
    """Folder of the run; runs/replay-DATE-TIME by default."""
    weights: Path | None = None
    """A classifier of your own, made by `circumspect export`; without it the shipped one."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self) -> int:
        """Replay, model, name, save."""
        from circumspect.classification import Classifier
        from circumspect.cli.recorded_poses import RecordedPoses
        from circumspect.cli.run_screen import RunScreen, new_run_folder, tell_result
        from circumspect.mapping import KnownPoses, RegisteredPoses
        from circumspect.pipeline import RecognitionPipeline, RunFolder
        from circumspect.recording import open_recording

        frames = open_recording(self.recording, self.every)
        segmentation = self._segmentation(frames)
        poses = RegisteredPoses() if self.poses == "hidden" else KnownPoses()
        pipeline = RecognitionPipeline(segmentation, poses, Classifier.load(self.weights))
        recorded = RecordedPoses()
        config = self._config(segmentation, pipeline)
        folder = RunFolder(self.out or new_run_folder("replay"), config)
        with RunScreen("replaying frames", len(frames)) as screen:
            pipeline.observers = (screen, folder)
            try:
                result = pipeline.run(recorded.hidden(frames) if self.poses == "hidden" else frames)
            except KeyboardInterrupt:
                screen.say(f"what was gathered so far is in {folder.path}")
                raise
            finally:
                for name, reason in frames.skipped.items():
                    screen.say(f"{name} left out: {reason}")
        head: dict[str, Any] = {"recording": str(self.recording), "skipped": len(frames.skipped)}
        head |= recorded.errors(result)
        tell_result(result, folder, self.json, head)
        if not self.json and "ate_rmse_m" in head:
            print(recorded.sentence(head))  # noqa: T201
        return 0

    def _segmentation(self, frames: FrameFolder) -> BoxSegmentation:
        import numpy as np

        from circumspect.sensing import BoxSegmentation

        corners = np.array(self.box).reshape(2, 3)
        if self.box_frame == "world":
            corners = frames.T_map_world.apply(corners)
        return BoxSegmentation(corners[0], corners[1])

    def _config(
        self, segmentation: BoxSegmentation, pipeline: RecognitionPipeline
    ) -> dict[str, Any]:
        from circumspect import __version__

        return {
            "command": "replay",
            "version": __version__,
            "recording": str(self.recording),
            "poses": self.poses,
            "every": self.every,
            "box": list(self.box),
            "box_frame": self.box_frame,
            "box_in_map": [
                [round(float(value), 4) for value in corner]
                for corner in (segmentation.low_xyz, segmentation.high_xyz)
            ],
            "segmentation": {"kind": "box", "noise": asdict(segmentation.noise)},
            "model": asdict(pipeline.model.settings),
            "grid": pipeline.classifier.recipe.to_dict(),
        }
