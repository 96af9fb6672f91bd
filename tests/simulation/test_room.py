from __future__ import annotations

import numpy as np
import pytest
from robot_world import CAMERA, true_pose

from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera
from circumspect.robot import Velocity
from circumspect.simulation import Room, Scene, SimulatedRobot, Station, block, cylinder, room
from circumspect.simulation.pioneer import RADIUS

SMALL = block((-0.15, -0.2, 0.0), (0.15, 0.2, 0.6))


def others(furnished: Room) -> list[np.ndarray]:
    """(n, 2) [m] points of each surface that is neither object nor floor, from the lane's axis."""
    surfaces = [s for s in furnished.scene.surfaces if s.name not in ("object", "floor")]
    centre = np.array(furnished.orbit.centre_xy)
    return [s.mesh.sampled(4000, 0).points_xyz[:, :2] - centre for s in surfaces]


@pytest.mark.parametrize("seed", range(6))
def test_the_lane_contains_only_the_object(seed: int) -> None:
    furnished = room(make_furniture(CATEGORIES[seed], seed), seed)
    nearest = [np.hypot(*points.T).min() for points in others(furnished)]
    assert min(nearest) >= furnished.lane_radius - 1e-6
    base = furnished.orbit.radius + furnished.mount.left
    assert furnished.lane_radius >= base + RADIUS + 0.15 - 1e-9
    # The near wall stands just behind the lane.
    assert nearest[0] == pytest.approx(furnished.lane_radius + 0.05, abs=0.05)


def test_there_are_four_walls_a_floor_and_clutter() -> None:
    names = [s.name for s in room(SMALL, 3, clutter=4).scene.surfaces]
    assert names[:6] == ["object", "floor", "wall-0", "wall-1", "wall-2", "wall-3"]
    assert len(names) == 10
    assert len(set(names)) == 10
    assert len(room(SMALL, 3, clutter=0).scene.surfaces) == 6


def test_rooms_differ_by_seed_only() -> None:
    one, same, other = (places(room(SMALL, seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)


def places(furnished: Room) -> np.ndarray:
    return np.array([s.mesh.vertices_xyz.mean(axis=0) for s in furnished.scene.surfaces])


@pytest.mark.parametrize("azimuth", [10, 45, 135, 270, 359, -30, 725])
def test_a_start_is_on_the_circle_with_the_object_on_the_left(azimuth: float) -> None:
    furnished = room(SMALL)
    start = furnished.start(azimuth)
    assert np.degrees(np.arctan2(start.y, start.x)) % 360 == pytest.approx(azimuth % 360)
    assert start.inverse().applied(furnished.orbit.centre_xy)[1] > 0
    T = start.as_transform() * furnished.mount.T_base_camera
    assert np.hypot(*T.translation[:2]) == pytest.approx(furnished.orbit.radius)
    x, y, z = T.inv().apply([0, 0, furnished.orbit.target_height])
    np.testing.assert_allclose([x, y], 0, atol=1e-9)
    assert z > 0


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_completes_the_orbit_without_a_collision(seed: int) -> None:
    furnished = room(make_furniture("chair", seed), seed)
    radius = furnished.orbit.radius + furnished.mount.left
    driver = SimulatedRobot(
        furnished.scene, furnished.start(50.0), furnished.mount, intrinsics=CAMERA
    )
    start = true_pose(driver)
    driver.drive(Velocity(0.5, 0.5 / radius))
    driver.wait(2 * np.pi * radius / 0.5 + 0.1)
    assert np.hypot(*(true_pose(driver).xy - start.xy)) < 0.15


def test_walls_and_clutter_can_be_seen_behind_the_object() -> None:
    camera = PinholeCamera(160, 120, 142.6, 142.6, 79.5, 59.5)
    furnished = room(SMALL, 1)
    seen: set[str] = set()
    driver = SimulatedRobot(furnished.scene, furnished.start(0), furnished.mount, intrinsics=camera)
    for azimuth in range(0, 360, 30):
        driver.place(furnished.start(azimuth))
        view = driver.camera.truth(Station(0.0, driver.truth().T_map_camera))
        near = np.unique(view.surface[view.depth < 3.5])
        seen |= {furnished.scene.surfaces[index].name for index in near}
        assert 0 in near
    assert any(name.startswith("wall") for name in seen)
    assert any(name.startswith(("box", "plant")) for name in seen)


def test_an_object_larger_than_the_range_is_refused() -> None:
    with pytest.raises(InputError, match="too large"):
        room(block((-20, -20, 0), (20, 20, 3)))


@pytest.mark.parametrize("height", [np.nan, np.inf, -np.inf, 0.001, 20.0, 1e30, 1e308])
def test_impossible_mast_heights_are_refused(height: float) -> None:
    with pytest.raises(InputError, match="a mast is from"):
        room(SMALL, height=height)


def test_an_invalid_start_is_refused() -> None:
    with pytest.raises(InputError, match="degrees"):
        room(SMALL).start(np.nan)


def test_a_cylinder_is_closed_and_of_its_size() -> None:
    mesh = cylinder(0.5, 0.2, 1.2, sides=96)
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    a, b, c = np.moveaxis(mesh.corners_xyz, 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(np.pi * 0.25, rel=0.01)
    assert isinstance(Scene.with_object(mesh), Scene)
