"""A recording that is opened with the settings of its flags."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from scipy.spatial.transform import RigidTransform

from circumspect.classification import Classifier
from circumspect.cli.run_screen import RunScreen
from circumspect.errors import GeometryError, InputError
from circumspect.evaluation.trajectory_error import places_and_turns, relative_pose_error
from circumspect.geometry import TrajectoryLog
from circumspect.recognition import RecognitionPipeline, RecognitionResult
from circumspect.recording import Recording
from circumspect.runs.replay_pipeline import replay_pipeline
from circumspect.runs.run_path import camera_path
from circumspect.sensing import BoxSegmentation, DepthNoise, RgbdFrame


class RecordedPoses:
    """Stores recorded poses of frames, and compares estimated poses with them."""

    def __init__(self) -> None:
        self._noted = TrajectoryLog()

    def noted(self, frames: Iterable[RgbdFrame]) -> Iterator[RgbdFrame]:
        """Yield the same frames and store their poses.

        The frames keep their poses, because only `Tracker` decides which frame starts the map. It
        uses the pose of that frame and of no other.
        """
        for frame in frames:
            if frame.T_map_camera is not None:
                self._noted.add(frame.stamp, frame.T_map_camera)
            yield frame

    def errors(self, result: RecognitionResult) -> dict[str, Any]:
        """Errors of the estimated poses against the recorded ones; empty without the latter.

        Returns:
            `ate_rmse_m` after rigid alignment; after alignment of the rotations
            `rotation_rmse_deg`, of the whole rotation, and `yaw_rmse_deg`, about the vertical
            alone; `frame_error_median_m`, the error of the motion between frames. Each is None if
            there are too few poses.
        """
        if not len(self._noted):
            return {}
        found, truth = camera_path(result), self._noted.trajectory
        names = ("ate_rmse_m", "rotation_rmse_deg", "yaw_rmse_deg", "frame_error_median_m")
        unknown: dict[str, Any] = dict.fromkeys(names)
        if found is None or truth is None:
            return unknown
        try:
            absolute = places_and_turns(found, truth)
            relative = relative_pose_error(found, truth)
        except (GeometryError, InputError):
            return unknown
        return {
            "ate_rmse_m": absolute.rmse_m,
            "rotation_rmse_deg": absolute.rotation_rmse_deg,
            "yaw_rmse_deg": absolute.yaw_rmse_deg,
            "frame_error_median_m": relative.median_m,
        }

    @staticmethod
    def sentence(errors: Mapping[str, Any]) -> str:
        """The errors in words."""
        if errors["ate_rmse_m"] is None:
            return "Too few poses were found to compare them with the recorded ones."
        return (
            f"The poses found are {1e3 * errors['ate_rmse_m']:.1f} mm off the recorded ones and "
            f"turned by {errors['rotation_rmse_deg']:.2f}°, about the vertical alone (yaw) by "
            f"{errors['yaw_rmse_deg']:.2f}° (RMSE); from frame to frame "
            f"{1e3 * errors['frame_error_median_m']:.1f} mm (median)."
        )


class OpenedRecording:
    """Frames with the sources of their poses and of their object."""

    def __init__(
        self,
        frames: Recording,
        box: BoxSegmentation | None,
        hidden: bool,
        T_map_first: RigidTransform | None = None,
        noise: DepthNoise | None = None,
    ) -> None:
        """Store the parts.

        Args:
            frames: The recording.
            box: Box round the object; None means segmentation of the floor in front of the robot.
            hidden: Estimate poses by registration; otherwise the recorded poses are used as true.
            T_map_first: Pose of the first frame, above the floor; None if the recording has it.
            noise: Noise and range of the camera; None means those of the Xtion PRO.
        """
        self.frames, self.box, self.hidden = frames, box, hidden
        self.T_map_first, self.noise = T_map_first, noise
        self.poses = RecordedPoses()
        """Recorded poses, stored if `hidden`."""

    def pipeline(self, classifier: Classifier) -> RecognitionPipeline:
        """The pipeline for the recording; see `replay_pipeline`."""
        return replay_pipeline(
            self.frames, classifier, self.box, self.hidden, self.T_map_first, self.noise
        )

    def given(self) -> Iterator[RgbdFrame]:
        """The frames for the pipeline; the first frame is read at once.

        Raises:
            InputError: The bag has no pose of the camera, or no frame can be read.
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
            return self.poses.noted(self.frames.from_first_pose())
        return self.frames.with_poses()

    @contextmanager
    def screen(self) -> Iterator[RunScreen]:
        """Show progress over the frames; skipped frames are reported at the end."""
        with RunScreen("replaying frames", len(self.frames)) as screen:
            try:
                yield screen
            finally:
                for line in left_out_lines(self.frames.skipped):
                    screen.say(line)


def left_out_lines(skipped: Mapping[str, str]) -> list[str]:
    """Lines about skipped items, one for each kind of reason.

    Args:
        skipped: Name of each skipped item to the reason. Reasons that differ only in numbers or in
            the name of the item are of the same kind.
    """
    kinds: dict[str, list[str]] = {}
    for name, reason in skipped.items():
        kinds.setdefault(re.sub(r"\d+", "#", reason.replace(name, "")), []).append(name)
    lines = []
    for names in kinds.values():
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        lines.append(f"{names[0]}{more} left out: {skipped[names[0]]}")
    return lines
