"""Recorded poses, kept from the pipeline and compared with what it finds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError, InputError
from circumspect.evaluation.trajectory_error import absolute_trajectory_error, relative_pose_error
from circumspect.pipeline import RecognitionResult
from circumspect.pipeline.camera_path import camera_path, increasing
from circumspect.sensing import RgbdFrame


class RecordedPoses:
    """Takes the poses off frames, and says in the end how far others are from them."""

    def __init__(self) -> None:
        self._taken: list[tuple[float, RigidTransform]] = []

    def hidden(self, frames: Iterable[RgbdFrame]) -> Iterator[RgbdFrame]:
        """The frames, of which only the first keeps its pose."""
        for frame in frames:
            known = bool(self._taken)
            if frame.T_map_camera is not None:
                self._taken.append((frame.stamp, frame.T_map_camera))
            yield replace(frame, T_map_camera=None) if known else frame

    def errors(self, result: RecognitionResult) -> dict[str, Any]:
        """Distances of the poses found to those recorded; empty where none were taken off.

        Returns:
            `ate_rmse_m`, `yaw_rmse_deg` after rigid alignment, and `frame_error_median_m`, the
            error of the motion from frame to frame. Each is None where there are too few poses.
        """
        if not self._taken:
            return {}
        found, truth = camera_path(result), increasing(self._taken)
        told: dict[str, Any] = {}
        told |= dict.fromkeys(("ate_rmse_m", "yaw_rmse_deg", "frame_error_median_m"))
        if found is None or truth is None:
            return told
        try:
            absolute = absolute_trajectory_error(found, truth)
            relative = relative_pose_error(found, truth)
        except (GeometryError, InputError):
            return told
        return {
            "ate_rmse_m": absolute.rmse_m,
            "yaw_rmse_deg": absolute.yaw_rmse_deg,
            "frame_error_median_m": relative.median_m,
        }

    @staticmethod
    def sentence(errors: Mapping[str, Any]) -> str:
        """The errors in words."""
        if errors["ate_rmse_m"] is None:
            return "Too few poses were found to compare them with the recorded ones."
        return (
            f"The poses found are {1e3 * errors['ate_rmse_m']:.1f} mm (RMSE) and "
            f"{errors['yaw_rmse_deg']:.2f}° off the recorded ones; from frame to frame "
            f"{1e3 * errors['frame_error_median_m']:.1f} mm (median)."
        )
