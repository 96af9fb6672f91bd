"""How far the robot drove, by wheels that may be wrong and poses that may be missing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.exploration.distance_meter import DistanceMeter
from circumspect.geometry import PlanarPose

SPEED, SECONDS = 0.05, 2.0
STEP = SPEED * SECONDS


def driven(
    *, wheels: float | None, certain: bool = True, really: float = STEP, back: bool = False
) -> list[float]:
    """After each of ten frames; `wheels` and `really` are the ways of a step [m].

    Args:
        wheels: What they say.
        certain: Whether all frames are placed, or only the first and the last one.
        really: What was driven.
        back: After half of the frames the robot drives back.
    """
    meter, told = DistanceMeter(), []
    meter.add_odometry(0.0, PlanarPose())
    meter.add_pose(PlanarPose())
    meter.set_speed(SPEED)
    for count in range(1, 11):
        at = 5 - abs(5 - count) if back else count
        meter.add_odometry(SECONDS * count, None if wheels is None else PlanarPose(at * wheels))
        meter.add_pose(PlanarPose(at * really) if certain or count == 10 else None)
        told.append(meter.metres)
    return told


@pytest.mark.parametrize("wheels", [STEP, 0.0, 5.0, None])
@pytest.mark.parametrize("back", [False, True])
def test_where_the_poses_are_certain_wheels_do_not_matter(wheels: float | None, back: bool) -> None:
    assert driven(wheels=wheels, back=back)[-1] == pytest.approx(1.0)


def test_a_robot_that_is_held_does_not_drive() -> None:
    assert driven(wheels=STEP, really=0.0)[-1] == 0.0


@pytest.mark.parametrize(("wheels", "metres"), [(0.09, 0.9), (5.0, 2.0), (None, 1.0)])
def test_without_poses_the_wheels_count_within_what_was_commanded(
    wheels: float | None, metres: float
) -> None:
    there_and_back = driven(wheels=wheels, certain=False, back=True)
    assert there_and_back[-1] == pytest.approx(metres)


def test_what_lies_between_two_certain_poses_was_driven_at_least() -> None:
    """Though the wheels were stuck and no frame in between was placed."""
    assert driven(wheels=0.0, certain=False)[-1] == pytest.approx(1.0)


def test_a_corrected_pose_is_no_way_driven() -> None:
    meter = DistanceMeter()
    meter.add_odometry(0.0, PlanarPose())
    meter.add_pose(PlanarPose())
    meter.add_odometry(1.0, PlanarPose())
    meter.add_pose(PlanarPose(0.03))
    assert meter.metres == 0.0
    meter.set_speed(SPEED)
    meter.add_odometry(1.0 + SECONDS, PlanarPose(STEP))
    meter.add_pose(PlanarPose(1.0))
    assert meter.metres == pytest.approx(2 * STEP)


def test_what_came_after_the_last_frame_counts_too() -> None:
    meter = DistanceMeter()
    meter.add_odometry(0.0, PlanarPose())
    meter.add_pose(PlanarPose())
    meter.set_speed(-SPEED)
    meter.add_odometry(SECONDS, PlanarPose(-0.08))
    assert meter.metres == pytest.approx(0.08)


@given(
    st.sampled_from([None, 0.0, 0.5 * STEP, STEP, 9.0]),
    st.floats(0, 0.3),
    st.booleans(),
    st.booleans(),
)
def test_the_way_never_shrinks_from_frame_to_frame(
    wheels: float | None, really: float, certain: bool, back: bool
) -> None:
    told = driven(wheels=wheels, certain=certain, really=really, back=back)
    assert (np.diff([0.0, *told]) >= -1e-12).all()
