"""Playback of a finished run: the dashboard's state at each frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.runs.playback_moment import PlaybackMoment
from circumspect.viewer.dashboard_state import NOTHING, DashboardState, FrameImages, ObjectSnapshot
from circumspect.viewer.saved_run import SavedRun


@dataclass(frozen=True)
class _View:
    """A view read from a file; see `PlannedView`."""

    T_map_base: PlanarPose
    looks_at_xy: tuple[float, float]
    normal_xy: tuple[float, float] | None


class PlayedRun:
    """Creates the `DashboardState` of any frame of a saved run."""

    def __init__(self, run: SavedRun) -> None:
        """Assign poses to frames."""
        self.run = run
        self._poses = _poses(run)
        self._path = _path(run, self._poses)
        truth = run.config.get("truth")
        self._truth = truth if isinstance(truth, str) else None
        self._views: dict[tuple[float, ...], _View] = {}
        points = run.points_xyz
        self._extent_xyz = np.stack([points.min(0), points.max(0)]) if len(points) else None

    def __len__(self) -> int:
        return len(self.run.rows)

    def state_at(self, frame: int) -> DashboardState:
        """The state at a frame.

        Args:
            frame: Number from 0; the last frame shows the final object with all points.
        """
        run, count = self.run, frame + 1
        moment = run.moment(frame)
        last = frame == len(run.rows) - 1
        snapshot = ObjectSnapshot()
        if last and len(run.points_xyz):
            snapshot = self._final(moment)
        elif moment is not None:
            snapshot = ObjectSnapshot(
                moment.points_xyz, moment.normals_xyz, moment.frames_seen, moment.grid
            )
        message = " · ".join(run.missing) if last or frame == 0 else ""
        return DashboardState(
            rows=run.rows,
            count=count,
            object_snapshot=snapshot,
            images=None
            if moment is None
            else FrameImages(moment.depth, moment.colour, moment.frame),
            camera=None if moment is None else moment.camera,
            T_map_camera=self._poses.get(frame),
            T_base_camera=None if moment is None else moment.T_base_camera,
            path_xyz=self._path[:count][np.isfinite(self._path[:count, 0])],
            odometry_xyz=run.odometry_until(frame),
            target=None if moment is None else self._target(moment),
            surroundings=run.surroundings,
            truth=self._truth,
            message=message,
            extent_xyz=self._extent_xyz,
        )

    def _final(self, moment: PlaybackMoment | None) -> ObjectSnapshot:
        """The object of model.ply, with the frame counts of the last moment."""
        run = self.run
        seen = np.ones(len(run.points_xyz), np.int64)
        if moment is not None and len(moment.points_xyz):
            from scipy.spatial import KDTree

            _, nearest = KDTree(moment.points_xyz).query(run.points_xyz)
            seen = moment.frames_seen[nearest]
        return ObjectSnapshot(run.points_xyz, run.normals_xyz, seen, run.grid)

    def _target(self, moment: PlaybackMoment) -> _View | None:
        """The next view; equal views are the same instance, so that they are drawn once."""
        if moment.target is None:
            return None
        x, y, yaw, looks_x, looks_y, azimuth = key = tuple(moment.target.tolist())
        normal = None
        if np.isfinite(azimuth):
            normal = (float(np.cos(azimuth)), float(np.sin(azimuth)))
        view = _View(PlanarPose(x, y, yaw), (looks_x, looks_y), normal)
        return self._views.setdefault(tuple(map(str, key)), view)  # pyright: ignore


def _poses(run: SavedRun) -> dict[int, RigidTransform]:
    """Poses by frame number, matched by stamp."""
    if run.trajectory is None:
        return {}
    numbers = {row["stamp"]: row["frame"] for row in run.rows}
    stamps = run.trajectory.stamps.tolist()
    return {
        numbers[stamp]: run.trajectory.T_map_camera[place]
        for place, stamp in enumerate(stamps)
        if stamp in numbers
    }


def _path(run: SavedRun, poses: dict[int, RigidTransform]) -> NDArray[np.float64]:
    """(n, 3) [m] position of the camera per frame; NaN if unknown."""
    places = np.full((len(run.rows), 3), np.nan)
    for place, row in enumerate(run.rows):
        pose = poses.get(row["frame"])
        if pose is not None:
            places[place] = pose.translation
        elif "camera_xyz" in row and not poses:
            places[place] = row["camera_xyz"]
    return places if len(places) else np.asarray(NOTHING, np.float64)
