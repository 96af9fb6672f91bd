"""Laws of the path follower on a robot that follows commands exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import PlanarPose
from circumspect.robot import PathFollower, arc

TICK = 0.1
FOLLOWER = PathFollower(max_turn=0.4)


def driven(path, goal, start, speed, follower=FOLLOWER, limit=400.0):
    """Poses on the way until the follower arrives."""
    poses, clock = [start], 0.0
    while (velocity := follower.velocity(poses[-1], path, goal, speed)) is not None:
        assert 0 <= velocity.forward <= speed + 1e-12
        assert abs(velocity.turn) <= follower.max_turn + 1e-12
        poses.append(poses[-1] @ arc(velocity.forward * TICK, velocity.turn * TICK))
        clock += TICK
        assert clock < limit, "never arrives"
    return poses


def arrived(poses, goal, follower=FOLLOWER) -> bool:
    gap = goal.inverse() @ poses[-1]
    return bool(
        np.hypot(gap.x, gap.y) <= follower.arrive + 1e-9
        and abs(gap.yaw) <= follower.arrive_yaw + 1e-9
    )


@settings(max_examples=40)
@given(
    heading=st.floats(-3.14, 3.14),
    goal_yaw=st.floats(-3.14, 3.14),
    length=st.floats(0.05, 3.0),
    speed=st.sampled_from([0.05, 0.2, 0.5]),
)
def test_arrives_on_a_line_from_any_heading(heading, goal_yaw, length, speed) -> None:
    path = np.column_stack([np.linspace(0, length, 30), np.zeros(30)])
    goal = PlanarPose(length, 0.0, goal_yaw)
    poses = driven(path, goal, PlanarPose(0, 0, heading), speed)
    assert arrived(poses, goal)


@settings(max_examples=40)
@given(
    radius=st.floats(0.5, 2.0),
    turn=st.floats(0.3, 4.5),
    heading=st.floats(-3.14, 3.14),
    side=st.sampled_from([-1, 1]),
)
def test_arrives_on_an_arc_and_stays_near_it(radius, turn, heading, side) -> None:
    angles = np.linspace(0, turn, 80)
    path = np.column_stack([radius * np.sin(angles), side * radius * (1 - np.cos(angles))])
    goal = PlanarPose(*path[-1], side * turn)
    poses = driven(path, goal, PlanarPose(0, 0, heading), 0.1)
    assert arrived(poses, goal)
    places = np.array([pose.xy for pose in poses])
    off = np.linalg.norm(places[:, None] - path[None], axis=2).min(axis=1)
    assert off.max() < 0.10


@settings(max_examples=40)
@given(x=st.floats(-1, 1), y=st.floats(-1, 1), heading=st.floats(-3.14, 3.14))
def test_arrives_from_beside_the_path(x, y, heading) -> None:
    path = np.column_stack([np.linspace(0, 2, 40), np.zeros(40)])
    goal = PlanarPose(2.0, 0.0, 0.0)
    assert arrived(driven(path, goal, PlanarPose(x, y, heading), 0.2), goal)


def test_a_robot_at_its_goal_gets_no_velocity() -> None:
    goal = PlanarPose(1.0, 2.0, 0.5)
    assert FOLLOWER.velocity(goal, np.array([[0, 0], [1.0, 2.0]]), goal, 0.05) is None


@pytest.mark.parametrize("turn", [3.0, -3.0])
def test_turns_in_place_by_the_smaller_angle(turn) -> None:
    goal = PlanarPose(0.0, 0.0, turn)
    poses = driven(np.zeros((2, 2)), goal, PlanarPose(), 0.1)
    assert np.abs([pose.x for pose in poses]).max() == 0.0
    assert np.sign(poses[1].yaw) == np.sign(turn)


def test_arrives_despite_noise_of_the_pose() -> None:
    rng = np.random.default_rng(0)
    path, goal = np.column_stack([np.linspace(0, 2, 40), np.zeros(40)]), PlanarPose(2, 0, 1.5)
    pose = PlanarPose(0, 0, 2.0)
    for _ in range(3000):
        believed = PlanarPose(
            pose.x + rng.normal(0, 0.005), pose.y + rng.normal(0, 0.005),
            pose.yaw + rng.normal(0, 0.01),
        )  # fmt: skip
        velocity = FOLLOWER.velocity(believed, path, goal, 0.1)
        if velocity is None:
            break
        pose = pose @ arc(velocity.forward * TICK, velocity.turn * TICK)
    assert velocity is None
    assert np.linalg.norm(pose.xy - goal.xy) < 0.08
