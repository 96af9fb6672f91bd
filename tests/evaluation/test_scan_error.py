from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.evaluation.scan_error import ScanError, scan_error
from circumspect.geometry import PinholeCamera, Trajectory
from circumspect.simulation import Scene, block, looking_at

BOX = block((-0.2, -0.3, 0.0), (0.2, 0.3, 0.8))
SCENE = Scene.with_object(BOX)
CAMERA = PinholeCamera(160, 120, 142.0, 142.0, 79.5, 59.5)
# The robot's map begins where it stands: elsewhere than the world, and turned.
T_WORLD_MAP = RigidTransform.from_components(
    [1.5, -0.4, 0.0], Rotation.from_euler("z", 70, degrees=True)
)


def round_trip(count: int = 10) -> Trajectory:
    angles = np.arange(count) * 2 * np.pi / count
    poses = [looking_at((1.6 * np.cos(a), 1.6 * np.sin(a), 1.2), (0, 0, 0.4)) for a in angles]
    return Trajectory(np.arange(count) * 0.5, RigidTransform.concatenate(poses))


def in_map(trajectory: Trajectory) -> Trajectory:
    return trajectory.moved(T_WORLD_MAP.inv())


def drifting(trajectory: Trajectory, metres: float) -> Trajectory:
    count = len(trajectory)
    drift = RigidTransform.from_translation(
        np.outer(np.linspace(0, metres, count), [1.0, 0.0, 0.0])
    )
    return Trajectory(trajectory.stamps, drift * trajectory.T_map_camera)


def test_a_perfect_scan_has_no_error_wherever_its_map_lies() -> None:
    truth = round_trip()
    points = T_WORLD_MAP.inv().apply(BOX.sampled(60_000).points_xyz)
    error = scan_error(truth, in_map(truth), drifting(truth, 0.3), points, SCENE, CAMERA)
    assert error.missing == ()
    assert error.trajectory.max_m < 1e-9
    assert error.from_start.max_m < 1e-9
    assert error.odometry.rmse_m > 0.03
    assert error.shape.chamfer_m < 0.003
    assert error.shape.completeness > 0.99
    summary = error.summary()
    assert json.loads(json.dumps(summary)) == summary
    assert summary["chamfer_m"] == error.shape.chamfer_m
    assert summary["ate_odometry_rmse_m"] == error.odometry.rmse_m


def test_a_model_beside_the_object_is_wrong() -> None:
    truth = round_trip()
    points = T_WORLD_MAP.inv().apply(BOX.sampled(20_000).points_xyz + np.array([0.1, 0, 0]))
    error = scan_error(truth, in_map(truth), None, points, SCENE, CAMERA)
    assert error.odometry is None
    assert error.shape.accuracy_m > 0.02
    assert error.shape.completeness < 0.8


def test_undefined_errors_are_omitted_with_a_reason() -> None:
    truth = round_trip()
    blind = scan_error(truth, in_map(truth), truth, np.empty((0, 3)), SCENE, CAMERA)
    assert blind.trajectory.max_m < 1e-9
    assert blind.shape is None
    assert blind.missing == ("shape: there is no object to compare",)
    alone = scan_error(truth, in_map(truth), None, None, SCENE, CAMERA)
    assert (alone.shape, alone.missing, alone.trajectory) == (None, (), blind.trajectory)
    assert scan_error(truth, None, None, BOX.vertices_xyz, SCENE, CAMERA) == ScanError()


def test_a_robot_that_never_moved_has_no_aligned_trajectory_but_a_shape() -> None:
    still = Trajectory(
        np.arange(4.0), RigidTransform.concatenate([round_trip().T_map_camera[0]] * 4)
    )
    error = scan_error(
        still,
        in_map(still),
        still,
        T_WORLD_MAP.inv().apply(BOX.sampled(60_000).points_xyz),
        SCENE,
        CAMERA,
    )
    assert error.trajectory is None
    assert error.from_start.rmse_m == pytest.approx(0, abs=1e-9)
    assert error.shape.completeness > 0.9
    assert error.summary()["ate_rmse_m"] is None
    assert error.missing[0].startswith("trajectory: the estimated places lie on a line")
