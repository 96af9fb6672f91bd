from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.reconstruction.view_density import (
    MAX_SIMILAR_VIEWS,
    SIMILAR_DISTANCE_M,
    ViewDensity,
)


def at(x: float, yaw_deg: float = 0.0, roll_deg: float = 0.0) -> RigidTransform:
    """A camera that looks along z, turned about the y axis after a roll about its own."""
    turned = Rotation.from_euler("yz", [yaw_deg, roll_deg], degrees=True)
    return RigidTransform.from_components([x, 0.3, 1.1], turned)


def test_views_of_a_standing_camera_are_limited() -> None:
    views = ViewDensity()
    accepted = [views.accept(at(0.0)) for _ in range(3 * MAX_SIMILAR_VIEWS)]
    assert accepted == [True] * MAX_SIMILAR_VIEWS + [False] * 2 * MAX_SIMILAR_VIEWS


def test_small_motion_and_roll_keep_the_viewpoint_and_larger_motion_changes_it() -> None:
    views = ViewDensity()
    for _ in range(MAX_SIMILAR_VIEWS):
        views.accept(at(0.0))
    assert not views.accept(at(0.9 * SIMILAR_DISTANCE_M))
    assert not views.accept(at(0.0, yaw_deg=11.0, roll_deg=60.0))
    assert views.accept(at(1.1 * SIMILAR_DISTANCE_M))
    assert views.accept(at(0.0, yaw_deg=13.0))
    assert views.accept(at(0.0, yaw_deg=180.0))


def test_all_views_are_accepted_at_the_speed_of_the_robot() -> None:
    """5 cm/s, two frames per second, three rounds."""
    views = ViewDensity()
    for _ in range(3):
        assert all(views.accept(at(0.025 * step)) for step in range(200))


@settings(max_examples=20)
@given(st.floats(0.0002, 0.002))
def test_views_of_a_slow_camera_are_accepted_without_gaps(step: float) -> None:
    views = ViewDensity()
    positions = np.arange(0.0, 0.8, step)
    accepted = positions[[views.accept(at(x)) for x in positions]]
    assert len(accepted) <= (0.8 / SIMILAR_DISTANCE_M + 1) * MAX_SIMILAR_VIEWS
    assert np.diff(accepted).max() < 1.01 * SIMILAR_DISTANCE_M
    assert positions[-1] - accepted[-1] < 1.01 * SIMILAR_DISTANCE_M
