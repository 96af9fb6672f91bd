"""How far the robot drove, by wheels that may be wrong and poses that may be missing."""

from __future__ import annotations

import pytest

from circumspect.geometry import PlanarPose
from circumspect.pipeline.driven_way import DrivenWay

STEP = 0.1


def driven(*, wheels: float | None, certain: bool = True, really: float = STEP) -> float:
    """After ten frames, before each of which `STEP` was commanded."""
    way = DrivenWay()
    way.placed(PlanarPose())
    for count in range(1, 11):
        way.moved(STEP, wheels)
        way.placed(PlanarPose(count * really) if certain else None)
    return way.metres


@pytest.mark.parametrize("wheels", [STEP, 0.0, 5.0, None])
def test_where_the_poses_are_certain_wheels_do_not_matter(wheels: float | None) -> None:
    assert driven(wheels=wheels) == pytest.approx(1.0)


def test_a_robot_that_is_held_does_not_drive() -> None:
    assert driven(wheels=STEP, really=0.0) == 0.0


@pytest.mark.parametrize(("wheels", "metres"), [(0.09, 0.9), (5.0, 2.0), (None, 1.0)])
def test_without_poses_the_wheels_count_within_what_was_commanded(
    wheels: float | None, metres: float
) -> None:
    assert driven(wheels=wheels, certain=False) == pytest.approx(metres)


def test_a_corrected_pose_is_no_way_driven() -> None:
    way = DrivenWay()
    way.placed(PlanarPose())
    way.placed(PlanarPose(0.03))
    assert way.metres == 0.0
    way.moved(STEP, STEP)
    way.placed(PlanarPose(1.0))
    assert way.metres == pytest.approx(2 * STEP)


def test_what_came_after_the_last_frame_counts_too() -> None:
    way = DrivenWay()
    way.placed(PlanarPose())
    way.moved(STEP, 0.08)
    assert way.metres == pytest.approx(0.08)
