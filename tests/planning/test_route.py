from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
from analytic_shapes import box, facing_centre, l_shape, planner_input, walls
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import PlanarPose
from circumspect.planning import NoPath, Route, is_free, route

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
def test_the_path_connects_robot_and_goal_clear_of_the_object(a, b) -> None:
    start, goal = facing_centre(a, 1.2), facing_centre(b, 1.4)
    planned = route(planner_input(THING, start, robot_radius=RADIUS), goal)
    assert isinstance(planned, Route)
    np.testing.assert_allclose(planned.path_xy[[0, -1]], [start.xy, goal.xy], atol=1e-9)
    gaps = np.linalg.norm(planned.path_xy[:, None] - THING[None, :, :2], axis=2)
    assert gaps.min() > RADIUS
    steps = np.linalg.norm(np.diff(planned.path_xy, axis=0), axis=1)
    assert steps.max() < 0.08
    direct = np.linalg.norm(goal.xy - start.xy)
    assert direct - 0.01 <= planned.length <= direct + 2.2


def test_the_path_on_a_free_floor_is_nearly_straight() -> None:
    start, goal = PlanarPose(-1.5, -1.6, 0), PlanarPose(1.7, -1.1, 1)
    planned = route(planner_input(THING, start), goal)
    assert isinstance(planned, Route)
    assert planned.length < 1.03 * np.linalg.norm(goal.xy - start.xy)


def test_the_preferred_distance_is_kept() -> None:
    start, goal = facing_centre(-0.9, 1.3), facing_centre(0.9, 1.3)
    gaps = []
    for preferred_distance in (0.0, 0.9):
        planned = route(planner_input(THING, start), goal, preferred_distance)
        assert isinstance(planned, Route)
        gaps.append(np.linalg.norm(planned.path_xy[:, None] - THING[None, :, :2], axis=2).min())
    assert gaps[1] > gaps[0] + 0.1


def test_the_path_avoids_the_legs_of_a_table_and_notches() -> None:
    legs = np.vstack([[[x, y, 0.4]] * 4 for x in (-0.7, 0.7) for y in (-0.7, 0.7)])
    spread = legs + np.tile([[0, 0, 0], [0.02, 0, 0], [0, 0.02, 0], [0.02, 0.02, 0]], (4, 1))
    for points in (np.repeat(spread, 3, axis=0), walls(l_shape().outline_xy)):
        start, goal = facing_centre(0.8, 1.8), facing_centre(0.8 + np.pi, 1.8)
        planned = route(planner_input(points, start), goal)
        assert isinstance(planned, Route)
        assert np.linalg.norm(planned.path_xy, axis=1).min() > 0.4


def test_reasons_for_no_path() -> None:
    start = facing_centre(0.0, 1.3)
    inside = route(planner_input(THING, start), PlanarPose(0.5, 0.0, 0))
    assert isinstance(inside, NoPath)
    assert "object" in inside.reason
    wall = line((1.2, -3), (1.2, 3))
    beside = route(
        planner_input(THING, PlanarPose(0, 1.5, 0), obstacles_xy=wall), PlanarPose(1.25, 0, 0)
    )
    assert isinstance(beside, NoPath)
    assert "obstacle" in beside.reason
    outside = route(planner_input(THING, start, obstacles_xy=room(2.0)), PlanarPose(3.0, 0.0, 0))
    assert isinstance(outside, NoPath)
    assert "no free path" in outside.reason


def test_an_object_as_wide_as_its_room_can_not_be_orbited() -> None:
    wide = walls(box(4.0, 0.5).outline_xy)
    start, goal = PlanarPose(0.0, -1.2, 0), PlanarPose(0.0, 1.2, 3)
    found = route(planner_input(wide, start, obstacles_xy=room(2.0)), goal)
    assert isinstance(found, NoPath)


def test_a_robot_too_close_to_the_object_drives_away() -> None:
    start = PlanarPose(0.0, -0.45, 0.0)
    planned = route(planner_input(THING, start), PlanarPose(0.0, -1.5, 0.0))
    assert isinstance(planned, Route)
    gaps = np.linalg.norm(planned.path_xy[:, None] - THING[None, :, :2], axis=2).min(axis=1)
    assert (np.diff(gaps) > -0.03).all()


def test_a_robot_too_close_does_not_drive_through_a_wall() -> None:
    wall = line((-3, -1.0), (3, -1.0))
    start = PlanarPose(0.0, -0.75, 0.0)
    found = route(planner_input(THING, start, obstacles_xy=wall), PlanarPose(0.0, -2.0, 0.0))
    if isinstance(found, Route):
        beyond = found.path_xy[np.abs(found.path_xy[:, 1] + 1.0) < 0.1]
        assert (np.abs(beyond[:, 0]) > 2.9).all()


def test_a_path_is_passable_unless_an_obstacle_is_on_its_rest() -> None:
    path = line((1.0, -1.5), (1.0, 1.5))
    base = PlanarPose(1.0, 0.0, np.pi / 2)
    free = planner_input(THING, base, robot_radius=RADIUS)
    assert is_free(free, path)
    behind = planner_input(THING, base, robot_radius=RADIUS, obstacles_xy=np.array([[1.0, -1.0]]))
    assert is_free(behind, path)
    ahead = planner_input(THING, base, robot_radius=RADIUS, obstacles_xy=np.array([[1.1, 1.0]]))
    assert not is_free(ahead, path)


def test_planning_a_path_is_fast() -> None:
    asked = planner_input(THING, facing_centre(0, 2.0), obstacles_xy=room(3.0))
    route(asked, facing_centre(3.0, 2.0))
    start = time.process_time()
    for _ in range(3):
        assert isinstance(route(asked, facing_centre(3.0, 2.0)), Route)
    assert (time.process_time() - start) / 3 < 0.5


def test_a_goal_very_far_away_is_refused() -> None:
    answer = route(planner_input(THING, facing_centre(0.0, 1.2)), PlanarPose(4e3, 0.0, 0.0))
    assert answer == NoPath("3999 m away is too far for a path")
