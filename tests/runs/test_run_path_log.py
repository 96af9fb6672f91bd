from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation
from small_world import frames, run

from circumspect.exploration.view_record import ViewOutcome
from circumspect.geometry import PlanarPose, Trajectory
from circumspect.planning import NextView
from circumspect.runs import RunFolder
from circumspect.runs.run_path import camera_path
from circumspect.runs.run_path_log import RunPathLog
from circumspect.sensing import Odometry

T_BASE_CAMERA = RigidTransform.from_components(
    [0.0, 0.165, 1.2], Rotation.from_euler("x", -110, degrees=True)
)
# The odometry starts elsewhere than the map, and so does the world frame.
T_ODOM_MAP = PlanarPose(3.0, -1.0, 0.7)
T_WORLD_MAP = PlanarPose(-2.0, 5.0, -1.1)


class FakeScan:
    """The part of a scan that the log reads: drift-free odometry in its own frame."""

    def __init__(self, with_odometry: bool = True, frames_without_odometry: int = 0) -> None:
        """
        Args:
            with_odometry: Whether its frames have odometry.
            frames_without_odometry: Number of first frames without odometry.
        """
        self.frame = None
        self.driven_m = 0.0
        near = NextView(PlanarPose(1.0, 0.0, 0.0), (0.3, 0.0), None, "")
        far = NextView(PlanarPose(9.0, 0.0, 0.0), (0.3, 0.0), None, "")
        self.views = [
            SimpleNamespace(view=near, outcome=ViewOutcome.REACHED),
            SimpleNamespace(view=far, outcome="behind a wall"),
        ]
        self._with_odometry, self._frames_without_odometry = with_odometry, frames_without_odometry

    def takes(self, frame):
        base = PlanarPose.from_transform(
            T_ODOM_MAP.as_transform() * frame.pose * T_BASE_CAMERA.inv()
        )
        self._frames_without_odometry -= 1
        has_odometry = self._with_odometry and self._frames_without_odometry < 0
        odometry = Odometry(frame.stamp, base) if has_odometry else None
        self.frame = replace(frame, odometry=odometry, T_base_camera=T_BASE_CAMERA)
        self.driven_m += 0.5
        return frame


def logged(scan: FakeScan, folder: RunFolder | None = None, **arguments):
    log = RunPathLog(scan, folder, **arguments)  # type: ignore[arg-type]
    observers = (log,) if folder is None else (log, folder)
    result = run((scan.takes(frame) for frame in frames(4)), *observers)
    return log, result


def test_the_distance_is_recorded_at_each_frame() -> None:
    log, result = logged(FakeScan())
    run_path = log.run_path(result)
    np.testing.assert_allclose(run_path.driven_m, [0.5, 1.0, 1.5, 2.0])
    np.testing.assert_allclose(run_path.driven_by(run_path.stamps), run_path.driven_m)
    assert [view.T_map_base.x for view in run_path.views] == [1.0]
    assert [view.T_map_base.x for view in run_path.missed] == [9.0]


def test_odometry_and_ground_truth_are_in_the_map_frame() -> None:
    path = camera_path(run(frames(4)))
    world = path.moved(T_WORLD_MAP.as_transform())
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 0]])
    log, result = logged(FakeScan(), truth=lambda: world, walls_xy=(T_WORLD_MAP.applied(square),))
    run_path = log.run_path(result)
    np.testing.assert_allclose(run_path.truth.positions_xyz, path.positions_xyz, atol=1e-9)
    np.testing.assert_allclose(run_path.walls_xy[0], square, atol=1e-9)
    assert np.linalg.norm(run_path.odometry.positions_xyz[0] - path.positions_xyz[0]) < 1e-9


def test_late_odometry_starts_at_the_pose_of_its_first_frame() -> None:
    scan = FakeScan(frames_without_odometry=2)
    log, result = logged(scan)
    path, wheels = camera_path(result), log.run_path(result).odometry
    assert len(wheels) == len(path) - 2
    np.testing.assert_allclose(wheels.positions_xyz[0], path.positions_xyz[2], atol=1e-9)


def test_without_odometry_and_ground_truth_there_are_no_such_paths() -> None:
    log, result = logged(FakeScan(with_odometry=False), walls_xy=(np.zeros((3, 2)),))
    run_path = log.run_path(result)
    assert (run_path.odometry, run_path.truth, run_path.walls_xy) == (None, None, ())
    assert log.odometry is None


def test_folder_draws_the_run_path(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, {})
    _, result = logged(FakeScan(), folder)
    assert len(folder.run_path.stamps) == len(result.steps)
    assert (tmp_path / "picture.png").exists()


def test_repeated_and_late_frames_are_skipped() -> None:
    scan = FakeScan()
    log = RunPathLog(scan)  # type: ignore[arg-type]
    shots = list(frames(3))
    result = run((scan.takes(shots[k]) for k in (0, 2, 1, 2)), log)
    run_path = log.run_path(result)
    np.testing.assert_allclose(run_path.stamps, [shots[0].stamp, shots[2].stamp])
    assert len(run_path.odometry) == 2


def test_a_run_without_any_frame_has_no_paths() -> None:
    somewhere = Trajectory(np.zeros(1), RigidTransform.identity(1))
    log = RunPathLog(FakeScan(), truth=lambda: somewhere)  # type: ignore[arg-type]
    run_path = log.run_path(run([], log))
    assert (run_path.odometry, run_path.truth) == (None, None)
    assert run_path.driven_by(np.array([1.0])) is None
