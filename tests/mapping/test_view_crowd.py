from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.mapping.view_crowd import ENOUGH, NEAR, ViewCrowd


def at(x: float, yaw_deg: float = 0.0, roll_deg: float = 0.0) -> RigidTransform:
    """A camera that looks along z, turned about its y axis after a roll about its own."""
    turned = Rotation.from_euler("yz", [yaw_deg, roll_deg], degrees=True)
    return RigidTransform.from_components([x, 0.3, 1.1], turned)


def test_of_a_camera_that_stands_so_many_views_are_wanted() -> None:
    crowd = ViewCrowd()
    admitted = [crowd.admits(at(0.0)) for _ in range(3 * ENOUGH)]
    assert admitted == [True] * ENOUGH + [False] * 2 * ENOUGH


def test_shaking_or_rolling_is_standing_and_turning_or_going_is_not() -> None:
    crowd = ViewCrowd()
    for _ in range(ENOUGH):
        crowd.admits(at(0.0))
    assert not crowd.admits(at(0.9 * NEAR))
    assert not crowd.admits(at(0.0, yaw_deg=11.0, roll_deg=60.0))
    assert crowd.admits(at(1.1 * NEAR))
    assert crowd.admits(at(0.0, yaw_deg=13.0))
    assert crowd.admits(at(0.0, yaw_deg=180.0))


def test_at_the_robot_s_own_pace_every_view_is_wanted() -> None:
    """5 cm/s, a frame every half second, and three rounds of it."""
    crowd = ViewCrowd()
    for _ in range(3):
        assert all(crowd.admits(at(0.025 * step)) for step in range(200))


@settings(max_examples=20)
@given(st.floats(0.0002, 0.002))
def test_between_the_views_of_a_slow_camera_there_are_no_gaps(step: float) -> None:
    crowd = ViewCrowd()
    places = np.arange(0.0, 0.8, step)
    admitted = places[[crowd.admits(at(x)) for x in places]]
    assert len(admitted) <= (0.8 / NEAR + 1) * ENOUGH
    assert np.diff(admitted).max() < 1.01 * NEAR
    assert places[-1] - admitted[-1] < 1.01 * NEAR
