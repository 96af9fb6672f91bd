"""Driven distance, from odometry that may be wrong and poses that may be missing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.exploration.frame_driver import DistanceMeter
from circumspect.geometry import PlanarPose

SPEED, SECONDS = 0.05, 2.0
STEP = SPEED * SECONDS


def driven(
    *, wheels: float | None, reliable: bool = True, true: float = STEP, back: bool = False
) -> list[float]:
    """Distances [m] after each of ten frames.

    Args:
        wheels: Distance of a step by odometry [m]; None for no odometry.
        reliable: Whether all frames have a pose, or only the first and the last.
        true: True distance of a step [m].
        back: Whether the robot drives back after half of the frames.
    """
    meter, distances_m = DistanceMeter(), []
    meter.add_odometry(0.0, PlanarPose())
    meter.add_pose(PlanarPose())
    meter.set_speed(SPEED)
    for count in range(1, 11):
        at = 5 - abs(5 - count) if back else count
        meter.add_odometry(SECONDS * count, None if wheels is None else PlanarPose(at * wheels))
        meter.add_pose(PlanarPose(at * true) if reliable or count == 10 else None)
        distances_m.append(meter.metres)
    return distances_m


@pytest.mark.parametrize("wheels", [STEP, 0.0, 5.0, None])
@pytest.mark.parametrize("back", [False, True])
def test_with_reliable_poses_odometry_is_ignored(wheels: float | None, back: bool) -> None:
    assert driven(wheels=wheels, back=back)[-1] == pytest.approx(1.0)


def test_a_blocked_robot_drives_no_distance() -> None:
    assert driven(wheels=STEP, true=0.0)[-1] == 0.0


@pytest.mark.parametrize(("wheels", "metres"), [(0.09, 0.9), (5.0, 2.0), (None, 1.0)])
def test_without_poses_odometry_counts_up_to_twice_the_commanded_distance(
    wheels: float | None, metres: float
) -> None:
    there_and_back = driven(wheels=wheels, reliable=False, back=True)
    assert there_and_back[-1] == pytest.approx(metres)


def test_the_distance_is_at_least_that_between_two_poses() -> None:
    """Even if odometry was stuck and no frame in between has a pose."""
    assert driven(wheels=0.0, reliable=False)[-1] == pytest.approx(1.0)


def test_a_pose_correction_adds_no_distance() -> None:
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


def test_odometry_after_the_last_pose_is_added() -> None:
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
def test_the_distance_never_decreases(
    wheels: float | None, true: float, reliable: bool, back: bool
) -> None:
    distances_m = driven(wheels=wheels, reliable=reliable, true=true, back=back)
    assert (np.diff([0.0, *distances_m]) >= -1e-12).all()
