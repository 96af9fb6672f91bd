from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PinholeCamera, PlanarPose, TriangleMesh
from circumspect.robot import Velocity
from circumspect.simulation import (
    DroppedFrames,
    GroundTruthRecorder,
    Scene,
    SimulatedRobot,
    Surface,
    block,
    outlines,
)

BOX = block((-0.3, -0.2, 0.0), (0.3, 0.2, 0.7))
CAMERA = PinholeCamera(80, 60, 71.0, 71.0, 39.5, 29.5)


def ground_truth() -> GroundTruthRecorder:
    return GroundTruthRecorder(
        SimulatedRobot(Scene.with_object(BOX), PlanarPose(1.5, 0.0, 1.6), intrinsics=CAMERA)
    )


def test_the_true_pose_of_every_frame_is_recorded() -> None:
    robot = ground_truth()
    places = []
    robot.drive(Velocity(0.2))
    for _ in range(3):
        robot.wait(0.5)
        stamp = robot.observe().stamp
        places.append((stamp, robot.simulated.truth().T_map_camera.translation))
    trajectory = robot.trajectory
    np.testing.assert_allclose(trajectory.stamps, [stamp for stamp, _ in places])
    np.testing.assert_allclose(trajectory.positions_xyz, [place for _, place in places])
    assert np.linalg.norm(np.diff(trajectory.positions_xyz, axis=0), axis=1).min() > 0.05


def test_frames_carry_no_true_pose() -> None:
    assert ground_truth().observe().T_map_camera is None


def test_two_frames_of_one_stamp_are_recorded_once() -> None:
    robot = ground_truth()
    robot.observe()
    robot.observe()
    assert len(robot.trajectory) == 1


def test_the_ground_truth_recorder_also_records_dropped_frames() -> None:
    inner = ground_truth()
    robot = DroppedFrames(inner, 0.5, seed=1)
    stamps = []
    for _ in range(4):
        robot.wait(0.5)
        stamps.append(robot.observe().stamp)
    assert set(stamps) <= set(inner.trajectory.stamps.tolist())


def test_a_trajectory_without_frames_is_refused() -> None:
    with pytest.raises(InputError, match="no frame was taken yet"):
        _ = ground_truth().trajectory


def test_outlines_exclude_floor_and_object() -> None:
    crate = Surface("crate", block((1.0, 1.0, 0.0), (1.5, 1.2, 0.4)))
    (outline,) = outlines(Scene.with_object(BOX, crate))
    np.testing.assert_array_equal(outline[0], outline[-1])
    assert {tuple(corner) for corner in outline} == {(1, 1), (1.5, 1), (1.5, 1.2), (1, 1.2)}
    assert outlines(Scene.with_object(BOX)) == ()


def test_a_surface_without_width_is_named() -> None:
    upright = TriangleMesh(np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 2]]), np.array([[0, 1, 2]]))
    with pytest.raises(GeometryError, match="'pole' has no width from above"):
        outlines(Scene.with_object(BOX, Surface("pole", upright)))
