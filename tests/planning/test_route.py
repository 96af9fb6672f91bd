from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
from analytic_shapes import box, facing_centre, l_shape, situation, walls
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import PlanarPose
from circumspect.planning import NoWay, Route, passable, route

RADIUS = 0.3
THING = walls(box(0.8, 0.5).outline_xy)


def line(start, end) -> np.ndarray:
    count = int(np.linalg.norm(np.subtract(end, start)) / 0.04) + 2
    return np.linspace(start, end, count)


def room(half: float) -> np.ndarray:
    corners = [(-half, -half), (half, -half), (half, half), (-half, half), (-half, -half)]
    return np.vstack([line(a, b) for a, b in pairwise(corners)])


@settings(max_examples=15)
@given(a=st.floats(0, 6.28), b=st.floats(0, 6.28))
def test_the_way_leads_from_robot_to_goal_clear_of_the_object(a, b) -> None:
    start, goal = facing_centre(a, 1.2), facing_centre(b, 1.4)
    way = route(situation(THING, start, robot_radius=RADIUS), goal)
    assert isinstance(way, Route)
    np.testing.assert_allclose(way.path_xy[[0, -1]], [start.xy, goal.xy], atol=1e-9)
    gaps = np.linalg.norm(way.path_xy[:, None] - THING[None, :, :2], axis=2)
    assert gaps.min() > RADIUS
    steps = np.linalg.norm(np.diff(way.path_xy, axis=0), axis=1)
    assert steps.max() < 0.08
    direct = np.linalg.norm(goal.xy - start.xy)
    assert direct - 0.01 <= way.length <= direct + 2.2


def test_on_a_free_floor_the_way_is_nearly_straight() -> None:
    start, goal = PlanarPose(-1.5, -1.6, 0), PlanarPose(1.7, -1.1, 1)
    way = route(situation(THING, start), goal)
    assert isinstance(way, Route)
    assert way.length < 1.03 * np.linalg.norm(goal.xy - start.xy)


def test_distance_that_is_worth_a_detour_is_kept() -> None:
    start, goal = facing_centre(-0.9, 1.3), facing_centre(0.9, 1.3)
    gaps = []
    for keep in (0.0, 0.9):
        way = route(situation(THING, start), goal, keep)
        assert isinstance(way, Route)
        gaps.append(np.linalg.norm(way.path_xy[:, None] - THING[None, :, :2], axis=2).min())
    assert gaps[1] > gaps[0] + 0.1


def test_nobody_drives_between_the_legs_of_a_table_nor_into_a_notch_to_get_through() -> None:
    legs = np.vstack([[[x, y, 0.4]] * 4 for x in (-0.7, 0.7) for y in (-0.7, 0.7)])
    spread = legs + np.tile([[0, 0, 0], [0.02, 0, 0], [0, 0.02, 0], [0.02, 0.02, 0]], (4, 1))
    for points in (np.repeat(spread, 3, axis=0), walls(l_shape().outline_xy)):
        start, goal = facing_centre(0.8, 1.8), facing_centre(0.8 + np.pi, 1.8)
        way = route(situation(points, start), goal)
        assert isinstance(way, Route)
        assert np.linalg.norm(way.path_xy, axis=1).min() > 0.4


def test_reasons_why_there_is_no_way() -> None:
    start = facing_centre(0.0, 1.3)
    inside = route(situation(THING, start), PlanarPose(0.5, 0.0, 0))
    assert isinstance(inside, NoWay)
    assert "object" in inside.why
    wall = line((1.2, -3), (1.2, 3))
    beside = route(
        situation(THING, PlanarPose(0, 1.5, 0), obstacles_xy=wall), PlanarPose(1.25, 0, 0)
    )
    assert isinstance(beside, NoWay)
    assert "obstacle" in beside.why
    outside = route(situation(THING, start, obstacles_xy=room(2.0)), PlanarPose(3.0, 0.0, 0))
    assert isinstance(outside, NoWay)
    assert "no free way" in outside.why


def test_an_object_as_wide_as_its_room_can_not_be_gone_round() -> None:
    wide = walls(box(4.0, 0.5).outline_xy)
    start, goal = PlanarPose(0.0, -1.2, 0), PlanarPose(0.0, 1.2, 3)
    found = route(situation(wide, start, obstacles_xy=room(2.0)), goal)
    assert isinstance(found, NoWay)


def test_a_robot_that_stands_too_close_gets_out() -> None:
    start = PlanarPose(0.0, -0.45, 0.0)
    way = route(situation(THING, start), PlanarPose(0.0, -1.5, 0.0))
    assert isinstance(way, Route)
    gaps = np.linalg.norm(way.path_xy[:, None] - THING[None, :, :2], axis=2).min(axis=1)
    assert (np.diff(gaps) > -0.03).all()


def test_but_not_through_a_wall_beside_it() -> None:
    wall = line((-3, -1.0), (3, -1.0))
    start = PlanarPose(0.0, -0.75, 0.0)
    found = route(situation(THING, start, obstacles_xy=wall), PlanarPose(0.0, -2.0, 0.0))
    if isinstance(found, Route):
        beyond = found.path_xy[np.abs(found.path_xy[:, 1] + 1.0) < 0.1]
        assert (np.abs(beyond[:, 0]) > 2.9).all()


def test_a_way_is_passable_until_something_stands_on_what_is_left_of_it() -> None:
    path = line((1.0, -1.5), (1.0, 1.5))
    base = PlanarPose(1.0, 0.0, np.pi / 2)
    free = situation(THING, base, robot_radius=RADIUS)
    assert passable(free, path)
    behind = situation(THING, base, robot_radius=RADIUS, obstacles_xy=np.array([[1.0, -1.0]]))
    assert passable(behind, path)
    ahead = situation(THING, base, robot_radius=RADIUS, obstacles_xy=np.array([[1.1, 1.0]]))
    assert not passable(ahead, path)


def test_planning_a_way_is_quick() -> None:
    asked = situation(THING, facing_centre(0, 2.0), obstacles_xy=room(3.0))
    route(asked, facing_centre(3.0, 2.0))
    start = time.process_time()
    for _ in range(3):
        assert isinstance(route(asked, facing_centre(3.0, 2.0)), Route)
    assert (time.process_time() - start) / 3 < 0.5


def test_a_goal_out_of_this_world_is_refused_without_a_map_of_the_way() -> None:
    answer = route(situation(THING, facing_centre(0.0, 1.2)), PlanarPose(4e3, 0.0, 0.0))
    assert answer == NoWay("3999 m away is too far to look for a way")
