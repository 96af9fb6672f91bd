from __future__ import annotations

import numpy as np

from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise
from circumspect.simulation import Orbit, Scene, SimulatedCamera, Station, block, looking_at

BOX = block((-0.2, -0.3, 0.0), (0.2, 0.3, 0.5))
CAMERA = PinholeCamera(160, 120, 142.6, 142.6, 79.5, 59.5)


def camera(seed: int = 0, noise: DepthNoise | None = None, colour: bool = False) -> SimulatedCamera:
    stations = Orbit.around(BOX, CAMERA).stations(6)
    return SimulatedCamera(Scene.with_object(BOX), stations.__next__, CAMERA, noise, seed, colour)


def test_the_same_seed_gives_the_same_frames() -> None:
    one, same, other = (
        np.stack([f.depth for f in camera(seed, DepthNoise()).frames(3)]) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other, equal_nan=True)


def test_without_noise_a_frame_is_the_truth() -> None:
    station = Station(0.0, looking_at([1.2, 0.5, 1.0], [0, 0, 0.2]))
    frame, truth = camera().photograph(station), camera().truth(station)
    np.testing.assert_array_equal(frame.depth, truth.depth)
    assert frame.stamp == 0.0


def test_frames_carry_their_camera_poses() -> None:
    orbit = Orbit.around(BOX, CAMERA)
    for index, frame in enumerate(camera().frames(4)):
        expected = orbit.station(2 * np.pi * index / 6)
        np.testing.assert_allclose(frame.pose.as_matrix(), expected.T_map_camera.as_matrix())
        assert frame.stamp == expected.stamp


def test_points_of_exact_frames_lie_on_the_box_and_the_floor() -> None:
    frame = next(camera().frames(1))
    points = frame.points_map()
    on_floor = np.abs(points[:, 2]) < 1e-4
    outside = np.maximum(np.abs(points) - [0.2, 0.3, 0.5], 0).max(axis=1)
    assert outside[~on_floor].max() < 1e-4
    assert on_floor.any()
    assert (~on_floor).any()


def test_object_floor_and_background_differ_in_colour() -> None:
    station = Station(0.0, looking_at([1.5, 0.0, 0.4], [0, 0, 0.4]))
    view = camera(colour=True)
    colour, surface = view.photograph(station).colour, view.truth(station).surface
    assert colour is not None
    assert (surface == -1).any()
    means = [colour[surface == index].mean(axis=0) for index in (0, 1, -1)]
    assert means[0][0] > means[0][2] + 30
    assert means[2].min() > 200
    assert camera().photograph(station).colour is None
