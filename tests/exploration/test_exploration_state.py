"""The exploration state while the robot is paused."""

from __future__ import annotations

from typing import cast

from circumspect.exploration.exploration_state import ExplorationState
from circumspect.robot import MobileRobot
from circumspect.sensing.viewing import looking


class Waiting:
    """A robot that only waits."""

    T_base_camera = looking((0.1, 0.0, 0.5), 0.0, 0.3)

    def __init__(self) -> None:
        self.now = self.paused_seconds = 0.0


def test_paused_time_does_not_count_as_time_without_a_pose() -> None:
    robot = Waiting()
    known = ExplorationState(cast("MobileRobot", robot))
    robot.now = 5.0
    assert known.blind_for == 5.0
    robot.now, robot.paused_seconds = 65.0, 60.0
    assert known.blind_for == 5.0
    assert known.doubted_for == 0.0
