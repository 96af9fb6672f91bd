"""A recording, opened as its flags say."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

from scipy.spatial.transform import RigidTransform

from circumspect.classification import Classifier
from circumspect.cli.recorded_poses import RecordedPoses
from circumspect.cli.run_screen import RunScreen
from circumspect.recognition import RecognitionPipeline
from circumspect.recording import BagRecording, Recording
from circumspect.runs.replay_pipeline import replay_pipeline
from circumspect.sensing import BoxSegmentation, DepthNoise, RgbdFrame


class OpenedRecording:
    """Frames, and what tells their poses and their object."""

    def __init__(
        self,
        frames: Recording,
        box: BoxSegmentation | None,
        hidden: bool,
        T_map_first: RigidTransform | None = None,
        noise: DepthNoise | None = None,
    ) -> None:
        """Put together what belongs together.

        Args:
            frames: The recording.
            box: Round the object; None means what stands on the floor before the robot.
            hidden: Poses are found by registration; else the recorded ones are taken as true.
            T_map_first: Pose of the first frame, above the floor; None means that the recording
                tells it.
            noise: The camera's noise and range; None means the Xtion PRO's.
        """
        self.frames, self.box, self.hidden = frames, box, hidden
        self.T_map_first, self.noise = T_map_first, noise
        self.poses = RecordedPoses()
        """Those of the frames, noted where they are hidden."""

    def pipeline(self, classifier: Classifier) -> RecognitionPipeline:
        """The pipeline for it; see `replay_pipeline`."""
        return replay_pipeline(
            self.frames, classifier, self.box, self.hidden, self.T_map_first, self.noise
        )

    def given(self) -> Iterator[RgbdFrame]:
        """The frames as the pipeline is to have them; the first one is read already.

        Raises:
            InputError: Of a bag, nothing tells where the camera is; or no frame can be read.
        """
        frames = iter(self._given())
        first = next(frames, None)

        def all_of_them() -> Iterator[RgbdFrame]:
            if first is not None:
                yield first
            yield from frames

        return all_of_them()

    def _given(self) -> Iterable[RgbdFrame]:
        if self.hidden:
            return self.poses.noted(self.frames.placed())
        # A bag's frames may lack poses.
        return self.frames.with_poses() if isinstance(self.frames, BagRecording) else self.frames

    @contextmanager
    def screen(self) -> Iterator[RunScreen]:
        """Progress over the frames; in the end what was left out is told."""
        with RunScreen("replaying frames", len(self.frames)) as screen:
            try:
                yield screen
            finally:
                for line in left_out_lines(self.frames.skipped):
                    screen.say(line)


def left_out_lines(skipped: Mapping[str, str]) -> list[str]:
    """What was left out, a line for each kind of reason.

    Args:
        skipped: Names of what was left out to the reason why. Reasons that differ in numbers or in
            their own name alone are of a kind.
    """
    kinds: dict[str, list[str]] = {}
    for name, reason in skipped.items():
        kinds.setdefault(re.sub(r"\d+", "#", reason.replace(name, "")), []).append(name)
    lines = []
    for names in kinds.values():
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        lines.append(f"{names[0]}{more} left out: {skipped[names[0]]}")
    return lines
