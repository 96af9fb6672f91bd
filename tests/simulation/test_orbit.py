from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera
from circumspect.simulation import Orbit, block, looking_at

CAMERA = PinholeCamera.xtion()


@pytest.mark.parametrize("category", CATEGORIES)
def test_the_whole_object_is_in_the_picture_and_in_range_from_everywhere(category: str) -> None:
    mesh = make_furniture(category, 3)
    orbit = Orbit.around(mesh, CAMERA, start=0.3)
    for station in islice(orbit.stations(17), 17):
        x, y, z = station.T_map_camera.inv().apply(mesh.vertices_xyz).T
        assert z.min() >= 0.8
        u, v = CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy
        # A pixel more than the search allows, which samples other headings than these.
        assert u.min() > 0
        assert u.max() < CAMERA.width
        assert v.min() > 0
        assert v.max() < CAMERA.height


def test_a_small_object_is_orbited_at_the_distance_of_the_paper() -> None:
    orbit = Orbit.around(block((-0.1, -0.1, 0.0), (0.1, 0.1, 0.3)), CAMERA)
    assert orbit.radius - 0.1 * np.sqrt(2) == pytest.approx(0.8, abs=0.03)


def test_stations_go_once_round_with_the_object_on_the_left() -> None:
    orbit = Orbit(radius=1.5, start=np.radians(30), centre_xy=(0.4, -0.2))
    stations = list(islice(orbit.stations(8), 9))
    places = np.array([s.T_map_camera.translation for s in stations])
    np.testing.assert_allclose(places[8], places[0], atol=1e-9)
    np.testing.assert_allclose(np.hypot(*(places[:, :2] - [0.4, -0.2]).T), 1.5)
    np.testing.assert_allclose(places[0], [0.4 + 1.5 * np.cos(np.pi / 6), -0.2 + 0.75, 1.2])
    heading = places[1] - places[0]
    towards_object = np.array([0.4, -0.2, 0]) - places[0]
    assert np.cross(heading, towards_object)[2] > 0


def test_stamps_follow_the_speed_of_the_paper() -> None:
    stations = list(islice(Orbit(radius=2.0).stations(10), 10))
    steps = np.diff([s.stamp for s in stations])
    np.testing.assert_allclose(steps, 2 * np.pi * 2.0 / 10 / 0.05)


def test_the_camera_is_upright_and_looks_at_its_target() -> None:
    pose = looking_at([2.0, 1.0, 1.2], [0.3, 0.1, 0.4])
    right, down, forward = pose.rotation.as_matrix().T
    assert right[2] == pytest.approx(0)
    assert down[2] < 0
    np.testing.assert_allclose(pose.inv().apply([0.3, 0.1, 0.4])[:2], 0, atol=1e-12)
    assert np.linalg.det(np.column_stack([right, down, forward])) == pytest.approx(1)


@pytest.mark.parametrize("unit", [1000.0, 0.001])
def test_an_object_in_other_units_is_refused_with_a_hint(unit: float) -> None:
    half, height = 0.5 * unit, 0.9 * unit
    with pytest.raises(InputError, match="are its units metres"):
        Orbit.around(block((-half, -half, 0), (half, half, height)), CAMERA)
