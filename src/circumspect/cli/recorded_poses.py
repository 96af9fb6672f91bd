"""Recorded poses, compared with what registration finds without them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from circumspect.errors import GeometryError, InputError
from circumspect.evaluation.trajectory_error import places_and_turns, relative_pose_error
from circumspect.geometry import TrajectoryLog
from circumspect.recognition import RecognitionResult
from circumspect.runs.camera_path import camera_path
from circumspect.sensing import RgbdFrame


class RecordedPoses:
    """Notes the poses of frames, and says in the end how far others are from them."""

    def __init__(self) -> None:
        self._noted = TrajectoryLog()

    def noted(self, frames: Iterable[RgbdFrame]) -> Iterator[RgbdFrame]:
        """The same frames.

        They keep their poses: which frame shows enough to begin a map, only `Tracker`
        knows, and it takes the pose of that one and looks at no other.
        """
        for frame in frames:
            if frame.T_map_camera is not None:
                self._noted.add(frame.stamp, frame.T_map_camera)
            yield frame

    def errors(self, result: RecognitionResult) -> dict[str, Any]:
        """Distances of the poses found to those recorded; empty where none were noted.

        Returns:
            `ate_rmse_m` after rigid alignment; after that of the turns `rotation_rmse_deg`, of the
            whole turn, and `yaw_rmse_deg`, about the vertical alone; `frame_error_median_m`, the
            error of the motion from frame to frame. Each is None where there are too few poses.
        """
        if not len(self._noted):
            return {}
        found, truth = camera_path(result), self._noted.trajectory
        names = ("ate_rmse_m", "rotation_rmse_deg", "yaw_rmse_deg", "frame_error_median_m")
        told: dict[str, Any] = dict.fromkeys(names)
        if found is None or truth is None:
            return told
        try:
            absolute = places_and_turns(found, truth)
            relative = relative_pose_error(found, truth)
        except (GeometryError, InputError):
            return told
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
