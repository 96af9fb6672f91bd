"""The GICP baseline of registration, and its figures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.plain_gicp import PlainGicp
from benchmarks.redkitchen import HEAD, WORDS, Run, figures, rows
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, Trajectory
from circumspect.sensing import DepthNoise, RgbdFrame
from circumspect.simulation import Scene, SimulatedCamera, Station, Surface, block, looking_at
from circumspect.tracking import Tracker

CAMERA = PinholeCamera(240, 180, 214.0, 214.0, 119.5, 89.5)
CORNER = (
    Surface("object", block((-0.3, -0.2, 0.0), (0.3, 0.2, 0.5))),
    Surface("floor", block((-6, -6, -0.1), (6, 6, 0.0))),
    Surface("wall", block((-1.5, -3.0, 0.0), (-1.4, 3.0, 2.0))),
    Surface("other wall", block((-3.0, 1.4, 0.0), (3.0, 1.5, 2.0))),
)
PLACES = [(1.4 + 0.002 * step**2, -1.2 + 0.01 * step, 1.1) for step in range(8)]


@pytest.fixture(scope="module")
def frames() -> tuple[RgbdFrame, ...]:
    begin = Station(0.0, RigidTransform.identity())
    camera = SimulatedCamera(Scene(CORNER), lambda: begin, CAMERA, DepthNoise(), 0)
    return tuple(
        camera.photograph(Station(float(number), looking_at(place, (0.0, 0.0, 0.3))))
        for number, place in enumerate(PLACES)
    )


@pytest.fixture(scope="module")
def truth(frames: tuple[RgbdFrame, ...]) -> Trajectory:
    poses = RigidTransform.concatenate([frame.pose for frame in frames])
    return Trajectory(np.array([frame.stamp for frame in frames]), poses)


def test_a_standing_camera_keeps_its_initial_pose(frames: tuple[RgbdFrame, ...]) -> None:
    poses = PlainGicp(max_depth=3.5)
    begun = poses.track(frames[0])
    np.testing.assert_allclose(begun.as_matrix(), frames[0].pose.as_matrix(), atol=1e-9)
    for _ in range(3):
        stands = poses.track(replace(frames[0], T_map_camera=None))
        moved = frames[0].pose.inv() * stands
        assert np.linalg.norm(moved.translation) < 1e-3
        assert moved.rotation.magnitude() < 1e-3


def test_points_beyond_the_range_are_not_used(frames: tuple[RgbdFrame, ...]) -> None:
    sizes = []
    for max_depth in (1.5, 3.5):
        poses = PlainGicp(max_depth)
        poses.track(frames[0])
        sizes.append(poses._model.size())
    assert 0 < sizes[0] < sizes[1]


def test_each_row_is_of_its_own_poses(frames: tuple[RgbdFrame, ...], truth: Trajectory) -> None:
    ours = Tracker()
    tracked = [ours.track(frames[0])]
    tracked += [ours.track(replace(frame, T_map_camera=None)) for frame in frames[1:]]
    final = Trajectory(truth.stamps, RigidTransform.concatenate(ours.corrected(tracked)))
    true, took = truth.T_map_camera, np.full(len(tracked), 7.0)
    astray = RigidTransform.concatenate([true[:-1], RigidTransform.from_translation([0, 0, 9])])
    others = {"small_gicp": (true, 2 * took), "small_gicp_all": (astray, took)}
    measured = figures(Run(truth, tuple(tracked), final, took), others)
    assert measured["small_gicp"]["milliseconds"] == {"median": 14.0, "p95": 14.0}
    assert measured["small_gicp"]["absolute"]["max_m"] < 1e-9
    assert measured["small_gicp_all"]["absolute"]["max_m"] > 1.0
    assert 1e-6 < measured["live"]["absolute"]["max_m"] < 0.05
    lines = rows(measured)
    assert [line[0] for line in lines] == list(WORDS.values())
    assert {len(line) for line in lines} == {len(HEAD)}
